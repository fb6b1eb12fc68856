"""Curves and figures over REST: the whole way from stored measurements."""

import json
import statistics
from collections.abc import Iterator
from typing import Any

import pytest
from starlette.testclient import TestClient

import physics
from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import RANDOM, rising, train
from workers.messages.run_spec import RunSpec

Json = dict[str, Any]


def curves_of(answer: Json) -> Iterator[Json]:
    for panel in answer["panels"]:
        yield from panel["curves"]


def test_mean_and_band_of_all_seeds(reader: TestClient, trained: str) -> None:
    answer = reader.get(f"{trained}/curves?normalized=false").json()
    assert answer == answer | {
        "sweep": trained.rpartition("/")[2],
        "metric": "return_mean",
        "normalized": False,
        "band": "std",
        "x": "timesteps",
    }
    assert [panel["environment"] for panel in answer["panels"]] == ["MassPoint", "Pendulum"]
    for panel in answer["panels"]:
        assert panel["random_return"]["mean"] == RANDOM
        assert panel["random_return"]["episodes"] == 1000
        for name, curve in zip(("ddpg", "hybrid-ddpg"), panel["curves"], strict=True):
            assert (curve["algorithm"], curve["label"], curve["runs"]) == (name, name, 3)
            assert curve["x"] == [800, 1600, 2400, 3200, 4000]
            assert curve["n"] == [3] * 5
            for j, timestep in enumerate(curve["x"]):
                seeds = [
                    rising(RunSpec(name, panel["environment"], seed), timestep) for seed in range(3)
                ]
                mean, deviation = statistics.mean(seeds), statistics.stdev(seeds)
                assert curve["mean"][j] == pytest.approx(mean, rel=1e-8)
                assert curve["low"][j] == pytest.approx(mean - deviation, rel=1e-8)
                assert curve["high"][j] == pytest.approx(mean + deviation, rel=1e-8)


def test_a_run_alone_is_its_own_mean(reader: TestClient, trained: str) -> None:
    for run in (reader.get(f"{trained}/runs").json()["items"])[::5]:
        number = run["id"].rpartition("-")[2]
        answer = reader.get(f"{trained}/curves?normalized=false&run={number}").json()
        [curve] = curves_of(answer)
        [panel] = answer["panels"]
        spec = RunSpec(run["algorithm"], run["environment"], run["seed"])
        assert panel["environment"] == run["environment"]
        assert curve["mean"] == [pytest.approx(rising(spec, x), rel=1e-8) for x in curve["x"]]
        assert set(curve["n"]) == {1}
        assert set(curve["low"]) == {None}
    assert reader.get(f"{trained}/curves?run=99").json()["panels"] == []


def test_normalised_zero_is_random_and_one_is_the_best(reader: TestClient, trained: str) -> None:
    raw = reader.get(f"{trained}/curves?normalized=false").json()
    normalised = reader.get(f"{trained}/curves").json()
    assert normalised["normalized"] is True
    assert "Normalised: 0 is the mean return of uniform random" in normalised["definition"]
    task = physics.make("Pendulum")
    best = task.max_reward * task.horizon
    for before, after in zip(curves_of(raw), curves_of(normalised), strict=True):
        for part in ("mean", "low", "high"):
            expected = [(each - RANDOM) / (best - RANDOM) for each in before[part]]
            assert after[part] == pytest.approx(expected, rel=1e-7, abs=1e-7)


def test_without_a_random_return_nothing_is_normalised(client: TestClient, store: Store) -> None:
    link = client.post("/api/v1/sweeps", json=SWEEP).json()["links"]["self"]
    train(store, 5, rising)
    response = client.get(f"{link}/curves")
    answer = json.loads(response.text, parse_constant=pytest.fail)
    for panel in answer["panels"]:
        assert panel["random_return"] is None
    for curve in curves_of(answer):
        assert curve["mean"] == [None] * 5
        assert curve["n"] == [0] * 5
    raw = client.get(f"{link}/curves?normalized=false").json()
    assert all(curve["n"] == [3] * 5 for curve in curves_of(raw))


def test_single_seeds_on_request(reader: TestClient, trained: str) -> None:
    assert "seeds" not in next(curves_of(reader.get(f"{trained}/curves").json()))
    answer = reader.get(f"{trained}/curves?seeds=true&normalized=false").json()
    for number, curve in enumerate(curves_of(answer)):
        spec = RunSpec(curve["algorithm"], "Pendulum", 0)
        for seed in range(3):
            one = curve["seeds"][seed]
            assert one["seed"] == seed
            assert one["run_id"].endswith(f"-{3 * number + seed}")
            run = reader.get(f"/api/v1/runs/{one['run_id']}").json()
            assert (run["algorithm"], run["seed"]) == (curve["algorithm"], seed)
            assert one["values"][0] == pytest.approx(rising(RunSpec(spec.algorithm, "", seed), 800))


@pytest.mark.parametrize("band", ["std", "ci95", "iqr"])
@pytest.mark.parametrize("metric", ["return_mean", "return_history", "critic_loss"])
@pytest.mark.parametrize("x", ["timesteps", "updates", "jacobians", "seconds"])
def test_every_view(reader: TestClient, trained: str, band: str, metric: str, x: str) -> None:
    response = reader.get(f"{trained}/curves", params={"band": band, "metric": metric, "x": x})
    assert response.status_code == 200, response.text
    answer = json.loads(response.text, parse_constant=pytest.fail)
    assert answer["normalized"] is (metric != "critic_loss")
    assert metric in answer["definition"]
    assert ("interpolated" in answer["definition"]) == (x == "seconds")
    assert ("processor time" in answer["definition"]) == (x == "seconds")
    for curve in curves_of(answer):
        points = len(curve["x"])
        assert points == 1 if (x, curve["algorithm"]) == ("jacobians", "ddpg") else points >= 5
        assert all(len(curve[part]) == points for part in ("mean", "low", "high", "n"))
        assert curve["x"] == sorted(set(curve["x"]))


def test_thinned_to_so_many_points(reader: TestClient, trained: str) -> None:
    whole = reader.get(f"{trained}/curves").json()
    thinned = reader.get(f"{trained}/curves?max_points=3").json()
    for before, after in zip(curves_of(whole), curves_of(thinned), strict=True):
        assert after["x"] == [800, 2400, 4000]
        assert after["mean"] == before["mean"][::2]


def test_a_running_sweep_counts_who_got_there(client: TestClient, store: Store) -> None:
    link = client.post("/api/v1/sweeps", json=changed(algorithms=[{"name": "ddpg"}])).json()[
        "links"
    ]
    assert all(curve["x"] == [] for curve in curves_of(client.get(link["curves"]).json()))
    claim = store.claim_cohort("worker", 60.0, limit=2)
    assert claim is not None
    store.release(claim, "given back")
    train(store, 2, rising, finish=False)
    answer = client.get(f"{link['curves']}?normalized=false").json()
    assert [curve["n"] for curve in curves_of(answer)] == [[3, 3], [3, 3]]


@pytest.mark.parametrize(
    ("query", "field", "says"),
    [
        ("metric=return_maen", "metric", "did you mean 'return_mean'?"),
        ("metric=a%00b", "metric", "NUL"),
        ("metric=critic_loss&normalized=true", "normalized", "only returns"),
        ("band=sem", "band", "std"),
        ("x=epochs", "x", "timesteps"),
        ("max_points=1", "max_points", "2"),
        ("max_points=1e9", "max_points", "integer"),
        ("nomalized=false", "nomalized", "is not known"),
    ],
)
def test_a_wrong_view_is_refused(
    reader: TestClient, trained: str, query: str, field: str, says: str
) -> None:
    response = reader.get(f"{trained}/curves?{query}")
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert error["field"] == field
    assert says in error["message"]
