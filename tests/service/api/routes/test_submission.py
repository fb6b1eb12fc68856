"""What a submission may not say: refused by field and limit, and nothing is queued."""

import json
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.api.schemas.requests.sweep_request import MAX_RUNS, MAX_SEED, MAX_TIMESTEPS
from service.api.schemas.requests.texts import MAX_NAME
from tests.service.conftest import SWEEP, algorithm, changed

Json = dict[str, Any]


def refusals(idle_client: TestClient, body: Json | bytes, query: str = "") -> dict[str, Json]:
    """Post what must be refused; the refusals by field."""
    content = body if isinstance(body, bytes) else json.dumps(body).encode()
    response = idle_client.post(
        f"/api/v1/sweeps{query}", content=content, headers={"Content-Type": "application/json"}
    )
    assert response.status_code == 422, response.text
    assert response.headers["content-type"] == "application/problem+json"
    assert idle_client.get("/api/v1/sweeps").json()["items"] == []
    return {error["field"]: error for error in response.json()["errors"]}


@pytest.mark.parametrize(
    ("body", "field", "limit"),
    [
        (changed(name=""), "name", 1),
        (changed(name="x" * (MAX_NAME + 1)), "name", MAX_NAME),
        (changed(name="a\0b"), "name", None),
        (changed(name=7), "name", None),
        (changed(algorithms=[]), "algorithms", 1),
        (changed(algorithms="ddpg"), "algorithms", None),
        (changed(algorithms=["ddpg"]), "algorithms[0]", None),
        (changed(environments=[]), "environments", 1),
        (changed(environments="Pendulum"), "environments", None),
        (changed(seeds=0), "seeds", 1),
        (changed(seeds=-1), "seeds", 1),
        (changed(seeds=True), "seeds", None),
        (changed(seeds="4"), "seeds", None),
        (changed(seeds=4.0), "seeds", None),
        (changed(seeds=None), "seeds", None),
        (changed(seeds=[]), "seeds", 1),
        (changed(seeds=[0, True]), "seeds[1]", None),
        (changed(seeds=[-1]), "seeds[0]", 0),
        (changed(seeds=[MAX_SEED + 1]), "seeds[0]", MAX_SEED),
        (changed(timesteps=0), "timesteps", 1),
        (changed(timesteps=MAX_TIMESTEPS + 1), "timesteps", MAX_TIMESTEPS),
        (changed(timesteps=10**400), "timesteps", MAX_TIMESTEPS),
        (changed(timesteps=True), "timesteps", None),
        (changed(scale=0), "scale", 0),
        (changed(scale=1.5), "scale", 1),
        (changed(priority=1001), "priority", 1000),
        (changed(priority=0.5), "priority", None),
        (changed(seed=4), "seed", None),
        (algorithm(weights={"w1": -0.1}), "algorithms[0].weights.w1", 0),
        (algorithm(weights={"w1": 1e7}), "algorithms[0].weights.w1", 1e6),
        (algorithm(weights={"w1": True}), "algorithms[0].weights.w1", None),
        (algorithm(weights={"w1": "1"}), "algorithms[0].weights.w1", None),
        (algorithm(weights={"w3": 1}), "algorithms[0].weights.w3", None),
        (algorithm(weights=[{"w2": -1}]), "algorithms[0].weights[0].w2", 0),
        (algorithm(weights=[]), "algorithms[0].weights", 1),
        (algorithm(weights=0.1), "algorithms[0].weights", None),
        (algorithm(config=[]), "algorithms[0].config", None),
        (algorithm(config={"a": {"b": 1}}), "algorithms[0].config.a", None),
        (algorithm(config={"a": 10**30}), "algorithms[0].config.a", None),
        (algorithm(environments=[]), "algorithms[0].environments", 1),
        (algorithm(environments=["Pendulum", "CartPole"]), "algorithms[0].environments[1]", None),
        (algorithm(wieghts={}), "algorithms[0].wieghts", None),
    ],
)
def test_what_is_wrong_is_refused_by_field_and_limit(
    idle_client: TestClient, body: Json, field: str, limit: float | None
) -> None:
    errors = refusals(idle_client, body)
    assert list(errors) == [field]
    assert errors[field]["limit"] == limit
    assert errors[field]["message"]


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", '"nan"'])
@pytest.mark.parametrize(
    ("place", "field"),
    [
        ('"algorithms":[{"name":"hybrid-ddpg","weights":{"w1":#}}]', "algorithms[0].weights.w1"),
        ('"algorithms":[{"name":"ddpg","config":{"tau":#}}]', "algorithms[0].config.tau"),
        ('"timesteps":#', "timesteps"),
        ('"seeds":[#]', "seeds[0]"),
    ],
)
def test_numbers_that_are_none_are_refused(
    idle_client: TestClient, number: str, place: str, field: str
) -> None:
    body = json.dumps(SWEEP)[:-1] + "," + place.replace("#", number) + "}"
    assert field in refusals(idle_client, body.encode())


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"", 422),
        (b"null", 422),
        (b"[]", 422),
        (b"{", 422),
        (b"\xff\xfe", 422),
        (b'{"name": "\\ud800"}', 422),
        (b'{"\\ud800": 1}', 422),
        (b"[" * 100_000, 400),
        (b'{"timesteps": ' + b"9" * 5000 + b"}", 400),
    ],
)
def test_what_is_no_json_of_ours_is_refused(
    idle_client: TestClient, body: bytes, status: int
) -> None:
    response = idle_client.post(
        "/api/v1/sweeps", content=body, headers={"Content-Type": "application/json"}
    )
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"


def test_a_form_of_another_page_is_no_json(idle_client: TestClient) -> None:
    response = idle_client.post(
        "/api/v1/sweeps", content=json.dumps(SWEEP), headers={"Content-Type": "text/plain"}
    )
    assert response.status_code == 422


def test_unknown_names_come_with_the_nearest(idle_client: TestClient) -> None:
    body = changed(algorithms=[{"name": "DDPG"}, {"name": "ddpg"}], environments=["pendulm"])
    errors = refusals(idle_client, body)
    assert set(errors) == {"algorithms[0].name", "environments[0]"}
    assert "did you mean 'ddpg'?" in errors["algorithms[0].name"]["message"]
    assert "did you mean 'Pendulum'?" in errors["environments[0]"]["message"]
    assert "MassPoint" in errors["environments[0]"]["message"]
    far = refusals(idle_client, changed(environments=["qqqqqqqq"]))["environments[0]"]["message"]
    assert "did you mean" not in far


@pytest.mark.parametrize(
    ("body", "field"),
    [
        (changed(seeds=[3, 4, 3]), "seeds[2]"),
        (changed(environments=["Pendulum", "Pendulum"]), "environments[1]"),
        (changed(algorithms=[{"name": "ddpg"}, {"name": "ddpg"}]), "algorithms[1]"),
        (algorithm(weights=[{"w1": 1}, {"w1": 1.0, "w2": 0}]), "algorithms[0].weights[1]"),
        (algorithm(weights=[{"w1": 0.0}, {"w1": -0.0}]), "algorithms[0].weights[1]"),
        (
            changed(algorithms=[{"name": "ddpg"}, {"name": "ddpg", "environments": ["Pendulum"]}]),
            "algorithms[1]",
        ),
        (
            changed(algorithms=[{"name": "ddpg", "environments": ["Pendulum", "Pendulum"]}]),
            "algorithms[0].environments[1]",
        ),
    ],
)
@pytest.mark.parametrize("query", ["", "?dry_run=true"])
def test_equal_runs_are_refused(
    idle_client: TestClient, body: Json, field: str, query: str
) -> None:
    assert "is the same as" in refusals(idle_client, body, query)[field]["message"]


HYBRID, DDPG = {"name": "hybrid-ddpg"}, {"name": "ddpg"}


@pytest.mark.parametrize(
    ("entries", "environment", "described"),
    [
        ([HYBRID, HYBRID | {"weights": {"w1": 1, "w2": 0}}], "MassPoint", "w1=1, w2=0"),
        ([HYBRID, HYBRID | {"weights": {"w1": 1.0}}], "MassPoint", "w1=1, w2=0"),
        ([DDPG, DDPG | {"config": {"noise": 0.3}}], "MassPoint", "noise=0.3"),
        ([DDPG, DDPG | {"config": {"gamma": 0.99}}], "Pendulum", "gamma=0.99"),
        ([DDPG, DDPG | {"weights": {"w1": 0, "w2": 0}}], "Pendulum", "noise=0.3"),
        (
            [DDPG | {"config": {"critic_decay": 0}}, DDPG | {"config": {"critic_decay": 0.0}}],
            "Pendulum",
            "critic_decay=0",
        ),
        (
            [DDPG | {"config": {"tau": 1}}, DDPG | {"config": {"tau": 1.0, "gamma": 0.99}}],
            "Pendulum",
            "tau=1",
        ),
    ],
)
def test_entries_equal_with_presets_filled_in_are_refused(
    idle_client: TestClient, entries: list[Json], environment: str, described: str
) -> None:
    """Or their seeds would be counted twice: one curve of n = 32 from 16 seeds."""
    body = changed(algorithms=entries, environments=[environment])
    [refusal] = refusals(idle_client, body).values()
    assert refusal["field"] == "algorithms[1]"
    assert f"is the same as algorithms[0] in {environment}" in refusal["message"]
    assert "with presets filled in" in refusal["message"]
    assert described in refusal["message"]
    assert refusal == refusals(idle_client, body, "?dry_run=true")["algorithms[1]"]


def test_entries_equal_in_some_tasks_are_refused_with_those(idle_client: TestClient) -> None:
    """DDPG's noise is 0.3 on MassPoint and CartPole, 0.6 on MountainCar."""
    names = ["MassPoint", "MountainCar", "CartPole"]
    body = changed(algorithms=[DDPG, DDPG | {"config": {"noise": 0.3}}], environments=names)
    [refusal] = refusals(idle_client, body).values()
    assert "is the same as algorithms[0] in MassPoint and CartPole" in refusal["message"]
    body = changed(
        algorithms=[DDPG, DDPG | {"config": {"noise": 0.3}, "environments": ["MountainCar"]}],
        environments=names,
    )
    assert idle_client.post("/api/v1/sweeps?dry_run=true", json=body).status_code == 200


def test_all_that_is_there_twice_is_told_at_once_with_all_else(idle_client: TestClient) -> None:
    body = changed(
        algorithms=[
            HYBRID | {"weights": [{"w1": 1}, {"w1": 0.1}, {"w1": 1, "w2": 0}]},
            HYBRID | {"weights": {"w1": 0.1}},
            {"name": "dppg"},
            DDPG | {"config": {"noise": 7}},
        ],
        environments=["MassPoint", "Pendulum", "MassPoint"],
        seeds=[4, 5, 4],
    )
    assert set(refusals(idle_client, body)) == {
        "algorithms[0].weights[2]",
        "algorithms[1]",
        "algorithms[2].name",
        "algorithms[3].config.noise",
        "environments[2]",
        "seeds[2]",
    }


@pytest.mark.parametrize(
    ("entries", "told"),
    [
        ([HYBRID | {"weights": {"w1": 0}}], ["algorithms[0] (hybrid-ddpg)"]),
        ([HYBRID | {"weights": [{"w1": 1}, {}]}], ["algorithms[0].weights[1] (hybrid-ddpg)"]),
        ([{"name": "hybrid-sac", "weights": {}}, {"name": "sac"}], ["It repeats algorithms[1]."]),
        (
            [DDPG, HYBRID | {"weights": {}}, {"name": "hybrid-ddpg-cosine", "weights": {}}],
            [
                "It repeats algorithms[0] and algorithms[2].",
                "It repeats algorithms[0] and algorithms[1].",
            ],
        ),
        ([DDPG | {"weights": {}}, HYBRID], []),
    ],
)
def test_hybrids_without_gradient_terms_are_told(
    client: TestClient, entries: list[Json], told: list[str]
) -> None:
    body = changed(algorithms=entries, environments=["Pendulum"])
    dry = client.post("/api/v1/sweeps?dry_run=true", json=body).json()["notices"]
    sweep = client.post("/api/v1/sweeps", json=body).json()
    assert sweep["notices"] == dry
    assert len(dry) == len(told)
    for notice, text in zip(dry, told, strict=True):
        assert text in notice
        assert "bit for bit" in notice
        assert "in Pendulum" in notice
    assert client.get(sweep["links"]["self"]).json()["notices"] == []


def test_weights_of_an_algorithm_without_gradient_terms(idle_client: TestClient) -> None:
    useless = changed(algorithms=[{"name": "ddpg", "weights": {"w1": 0.1}}])
    assert "no gradient terms" in refusals(idle_client, useless)["algorithms[0].weights"]["message"]
    zero = changed(algorithms=[{"name": "ddpg", "weights": {"w1": 0, "w2": 0}}])
    assert idle_client.post("/api/v1/sweeps?dry_run=true", json=zero).status_code == 200


@pytest.mark.parametrize(
    ("asked", "field", "says"),
    [
        ({"zip": ["w1", "noise"]}, "zip[0]", "'w1' is not a list of this algorithm"),
        ({"weights": {"w1": [0, 1]}, "zip": ["w1", "w1"]}, "zip[0]", "named twice"),
        ({"zip": ["noise", "tau"]}, "zip", "noise has 2, tau has 3"),
        ({"zip": ["noise"]}, "zip", "at least 2"),
        ({"weights": {"w1": [0, 0.0]}}, "weights.w1[1]", "is the same as"),
        ({"weights": [{"w1": 1}, {"w2": [1, 1]}]}, "weights[1].w2[1]", "is the same as"),
        ({"weights": {"w1": []}}, "weights.w1", "at least 1"),
        ({"weights": {"w1": [0, -1]}}, "weights.w1[1]", "greater than or equal to 0"),
        ({"config": {"noise": [0.1, 0.2, 0.1]}}, "config.noise[2]", "is the same as"),
        ({"label": " mine"}, "label", "without spaces around it"),
        ({"label": "a\x1b[31m"}, "label", "printable"),
        ({"label": ""}, "label", "at least 1"),
    ],
)
def test_grids_and_labels_are_refused_by_field(
    idle_client: TestClient, asked: Json, field: str, says: str
) -> None:
    grid = {"config": {"noise": [0.1, 0.2], "tau": [0.01, 0.02, 0.03]}}
    errors = refusals(idle_client, algorithm(**grid | asked))
    assert says in errors[f"algorithms[0].{field}"]["message"]


@pytest.mark.parametrize(
    ("algorithms", "field"),
    [
        ([DDPG | {"label": "x"}, {"name": "sac", "label": "x"}], "algorithms[1].label"),
        ([{"name": "sac", "label": "ddpg"}, DDPG], "algorithms[0].label"),
        ([DDPG, {"name": "sac", "label": "ddpg"}], "algorithms[1].label"),
    ],
)
def test_no_two_entries_have_one_label(
    idle_client: TestClient, algorithms: list[Json], field: str
) -> None:
    errors = refusals(idle_client, changed(algorithms=algorithms))
    assert list(errors) == [field]
    assert "another entry is called" in errors[field]["message"]


def test_a_grid_point_equal_to_another_entry_is_named(idle_client: TestClient) -> None:
    grid = HYBRID | {"config": {"noise": [0.1, 0.3]}}
    body = changed(algorithms=[grid, HYBRID], environments=["MassPoint"])
    [refusal] = refusals(idle_client, body).values()
    assert refusal["field"] == "algorithms[1]"
    assert "is the same as algorithms[0] with noise=0.3 in MassPoint" in refusal["message"]


def test_a_grid_above_the_cap_is_counted_and_not_expanded(idle_client: TestClient) -> None:
    axes = {f"x{i}": list(range(100)) for i in range(50)}
    assert refusals(idle_client, algorithm(config=axes))["seeds"]["limit"] == MAX_RUNS


@pytest.mark.parametrize("seeds", [10**9, 2**53 - 1, MAX_RUNS // 4 + 1])
def test_a_product_above_the_cap_is_counted_and_not_expanded(
    idle_client: TestClient, seeds: int
) -> None:
    error = refusals(idle_client, changed(seeds=seeds))["seeds"]
    assert error["limit"] == MAX_RUNS
    assert str(4 * seeds) in error["message"]


@pytest.mark.parametrize(
    ("config", "field", "limit", "says"),
    [
        ({"batch_size": 0}, "batch_size", 1, "greater than or equal to 1"),
        ({"batch_size": 4096}, "batch_size", 1024, "less than or equal to 1024"),
        ({"batch_size": True}, "batch_size", None, "valid integer"),
        ({"batch_size": 64.5}, "batch_size", None, "valid integer"),
        ({"tau": "0.1"}, "tau", None, "valid number"),
        ({"tau": [[0.1]]}, "tau[0]", None, "valid number"),
        ({"tau": [0.1, 2]}, "tau[1]", 1, "less than or equal to 1"),
        ({"tau": []}, "tau", None, "1 to 100 values"),
        ({"gama": [0.9, 0.8]}, "gama", None, "did you mean 'gamma'?"),
        ({"gama": 0.9}, "gama", None, "did you mean 'gamma'?"),
        ({"__class__": 1}, "__class__", None, "is not known"),
        ({"self": 1}, "self", None, "is not known"),
    ],
)
def test_settings_are_refused_by_name_and_range(
    idle_client: TestClient, config: Json, field: str, limit: float | None, says: str
) -> None:
    errors = refusals(idle_client, algorithm(config=config))
    assert list(errors) == [f"algorithms[0].config.{field}"]
    error = errors[f"algorithms[0].config.{field}"]
    assert says in error["message"]
    assert limit is None or error["limit"] == limit


def test_several_faults_are_told_at_once(idle_client: TestClient) -> None:
    errors = refusals(idle_client, changed(seeds=-1, timesteps=0, priority="x"))
    assert set(errors) == {"seeds", "timesteps", "priority"}


def test_very_many_faults_are_cut(idle_client: TestClient) -> None:
    assert len(refusals(idle_client, {**SWEEP, **{f"x{i}": 1 for i in range(1000)}})) == 100


def test_a_run_that_fits_no_worker_is_refused_with_the_timesteps_that_would(
    app: FastAPI, client: TestClient
) -> None:
    app.state.worker_memory = 50 * 10**6
    body = algorithm(weights={"w1": 0.1}) | {"environments": ["HalfCheetah"]}
    [refusal] = refusals(client, body | {"timesteps": 40_000}).values()
    assert refusal["field"] == "timesteps"
    assert refusal["message"] == (
        "a run of hybrid-ddpg on HalfCheetah needs up to 50.7 MB with algorithms[0], but the "
        "runs of a worker may fill 50.0 MB (D3PG_WORKER_MEMORY): ask for at most 39,432 timesteps, "
        "or set its replay_size to no more"
    )
    most = refusal["limit"]
    dry = "/api/v1/sweeps?dry_run=true"
    assert client.post(dry, json=body | {"timesteps": most + 1}).status_code == 422
    assert client.post(dry, json=body | {"timesteps": most}).status_code == 200
    small = algorithm(weights={"w1": 0.1}, config={"replay_size": most})
    small |= {"environments": ["HalfCheetah"], "timesteps": 10**6}
    assert client.post(dry, json=small).status_code == 200


def test_a_plan_that_fits_no_worker_is_refused(app: FastAPI, client: TestClient) -> None:
    app.state.worker_memory = 10**6
    body = changed(algorithms=[{"name": "mpc"}], environments=["HalfCheetah"])
    [refusal] = refusals(client, body).values()
    assert (refusal["field"], refusal["limit"]) == ("algorithms[0]", 10**6)
