"""Sweeps over REST: submitted, listed, shown, cancelled."""

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient

from service.api.schemas.requests.sweep_request import MAX_SEED
from service.api.schemas.requests.texts import MAX_NAME
from service.store.store import Store
from tests.service.conftest import SWEEP, FakeDispatcher, algorithm, changed
from tests.service.training import train


def test_a_product_becomes_runs(client: TestClient, store: Store) -> None:
    response = client.post("/api/v1/sweeps", json=SWEEP)
    assert response.status_code == 202
    sweep = response.json()
    assert response.headers["location"] == f"/api/v1/sweeps/{sweep['id']}"
    assert sweep["name"] == "small"
    assert sweep["status"] == "queued"
    assert sweep["runs"]["total"] == sweep["runs"]["queued"] == 2 * 2 * 3
    assert sweep["progress"] == 0
    assert sweep["eta_seconds"] is None
    assert sweep["request"] == SWEEP
    assert client.get(response.headers["location"]).json() == sweep
    for link in ("self", "runs", "curves"):
        assert client.get(sweep["links"][link]).status_code == 200
    specs = [run.spec for run in store.list_runs(sweep["id"])]
    product = {
        (spec.algorithm, spec.environment, spec.seed, spec.weights, spec.timesteps)
        for spec in specs
    }
    assert product == {
        (name, environment, seed, weights, 4000)
        for name, weights in (("ddpg", (0.0, 0.0)), ("hybrid-ddpg", (0.1, 0.01)))
        for environment in ("MassPoint", "Pendulum")
        for seed in range(3)
    }


def test_weights_and_seeds_may_be_listed(client: TestClient, store: Store) -> None:
    body = algorithm(weights=[{"w1": 1}, {"w2": 0.1}]) | {"seeds": [7, 0, MAX_SEED]}
    sweep = client.post("/api/v1/sweeps", json=body).json()
    runs = store.list_runs(sweep["id"])
    assert [run.spec.seed for run in runs] == [7, 0, MAX_SEED] * 4
    assert [run.spec.weights for run in runs[::3]] == [(1.0, 0.0), (0.0, 0.1)] * 2


def test_an_algorithm_may_run_in_some_of_the_environments(client: TestClient, store: Store) -> None:
    body = {
        "algorithms": [
            {"name": "ddpg"},
            {"name": "mpc", "environments": ["Pendulum"]},
            {"name": "hybrid-ddpg", "config": {"noise": 0.1}, "environments": ["Acrobot"]},
            {"name": "hybrid-ddpg", "config": {"noise": 0.2}, "environments": ["Pendulum"]},
        ],
        "environments": ["Pendulum", "Acrobot"],
        "seeds": 2,
    }
    sweep = client.post("/api/v1/sweeps", json=body).json()
    cells = {(run.spec.algorithm, run.spec.environment) for run in store.list_runs(sweep["id"])}
    assert cells == {
        ("ddpg", "Pendulum"),
        ("mpc", "Pendulum"),
        ("hybrid-ddpg", "Pendulum"),
        ("ddpg", "Acrobot"),
        ("hybrid-ddpg", "Acrobot"),
    }
    assert sweep["runs"]["total"] == 10


@pytest.mark.parametrize(("scale", "timesteps"), [(1, 4000), (0.4, 1600), (0.001, 800)])
def test_a_scale_takes_whole_measurements(
    client: TestClient, store: Store, scale: float, timesteps: int
) -> None:
    sweep = client.post("/api/v1/sweeps", json=changed(scale=scale, timesteps=4000)).json()
    assert {run.spec.timesteps for run in store.list_runs(sweep["id"])} == {timesteps}


def test_a_dry_run_queues_nothing(client: TestClient) -> None:
    response = client.post("/api/v1/sweeps?dry_run=true", json=SWEEP)
    assert response.status_code == 200
    answer = response.json()
    assert answer["runs"]["total"] == 12
    assert answer["timesteps"] == 12 * 4000
    assert [
        (cell["algorithm"], cell["environment"], cell["seeds"]) for cell in answer["cells"]
    ] == [
        ("ddpg", "MassPoint", 3),
        ("hybrid-ddpg", "MassPoint", 3),
        ("ddpg", "Pendulum", 3),
        ("hybrid-ddpg", "Pendulum", 3),
    ]
    assert client.get("/api/v1/sweeps").json()["items"] == []


def test_a_dry_run_learns_what_runs_cost(client: TestClient, store: Store) -> None:
    def answer() -> Any:
        return client.post("/api/v1/sweeps?dry_run=true", json=SWEEP).json()

    unlearnt = answer()
    assert {cell["cost"]["basis"] for cell in unlearnt["cells"]} == {"built-in figures"}
    client.post("/api/v1/sweeps", json=SWEEP)
    train(store, 5, lambda *_: 0.0)
    learnt = answer()
    # Seed s of `train` takes 4 s + s / 100 for 4000 timesteps: 12.03 s the three of a cell.
    for cell in learnt["cells"]:
        assert (cell["cost"]["basis"], cell["cost"]["runs"]) == ("same settings", 3)
        assert cell["cost"]["core_seconds"] == pytest.approx(12.03)
    estimate = learnt["estimate"]
    assert estimate["core_seconds"] == pytest.approx(4 * 12.03)
    assert estimate["workers"] == 2
    assert estimate["wall_seconds"] == pytest.approx(2 * 12.03)
    assert estimate["explanation"] == "4 of 4 cells from finished runs with the same settings."


def test_without_workers_there_is_no_wall_time(
    client: TestClient, dispatcher: FakeDispatcher
) -> None:
    dispatcher.workers = {}
    estimate = client.post("/api/v1/sweeps?dry_run=true", json=SWEEP).json()["estimate"]
    assert (estimate["wall_seconds"], estimate["workers"]) == (None, 0)


names = st.text(min_size=1, max_size=MAX_NAME).filter(lambda name: "\0" not in name)


@settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(names)
def test_any_name_is_kept_exactly(client: TestClient, name: str) -> None:
    sweep = client.post("/api/v1/sweeps", json=changed(name=name, seeds=1)).json()
    assert sweep["name"] == name
    assert client.get(sweep["links"]["self"]).json()["name"] == name


@pytest.mark.parametrize(
    "name",
    [
        "<img src=x onerror=alert(1)>",
        "=cmd|' /C calc'!A0",
        "../../etc/passwd",
        "%2e%2e%2f#?&",
        "\u202ertl\u202c 😀 日本",
        " leading and trailing ",
        "line\nbreak\ttab\r",
        "'; DROP TABLE runs; --",
    ],
)
def test_hostile_names_are_text(client: TestClient, name: str) -> None:
    sweep = client.post("/api/v1/sweeps", json=changed(name=name)).json()
    assert client.get(sweep["links"]["self"]).json()["name"] == name


@pytest.mark.parametrize(
    "sweep_id", ["nope", "0" * 12, "%00", "x" * 3000, "%F0%9F%98%80", "%2e%2e"]
)
@pytest.mark.parametrize("part", ["", "/runs", "/curves", "/plot.png", "/plot.svg", "/events"])
def test_an_unknown_sweep_is_not_found(idle_client: TestClient, sweep_id: str, part: str) -> None:
    response = idle_client.get(f"/api/v1/sweeps/{sweep_id}{part}")
    assert response.status_code == 404
    assert response.headers["content-type"] == "application/problem+json"


def test_cancelling_is_idempotent_and_final(client: TestClient) -> None:
    sweep = client.post("/api/v1/sweeps", json=SWEEP).json()
    for _ in range(2):
        response = client.post(sweep["links"]["cancel"])
        assert response.status_code == 202
        assert response.json()["status"] == "cancelled"
        assert response.json()["runs"]["cancelled"] == 12
    assert client.post("/api/v1/sweeps/nope/cancel").status_code == 404


def test_pages_follow_one_another(client: TestClient) -> None:
    made = [client.post("/api/v1/sweeps", json=changed(seeds=1)).json()["id"] for _ in range(5)]
    seen: list[str] = []
    url: str | None = "/api/v1/sweeps?limit=2"
    while url:
        response = client.get(url)
        seen += [sweep["id"] for sweep in response.json()["items"]]
        link = response.headers.get("link")
        assert (link is None) == (response.json()["next"] is None)
        url = link and link[1 : link.index(">")]
    assert seen == made[::-1]


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("limit=0", "limit"),
        ("limit=1001", "limit"),
        ("limit=x", "limit"),
        ("after=%00%00%00%00", "after"),
        ("after=nonsense!", "after"),
        ("after=%C3%A9", "after"),
        ("offset=3", "offset"),
    ],
)
def test_a_wrong_page_is_refused(idle_client: TestClient, query: str, field: str) -> None:
    response = idle_client.get(f"/api/v1/sweeps?{query}")
    assert response.status_code == 422
    assert [error["field"] for error in response.json()["errors"]] == [field]
