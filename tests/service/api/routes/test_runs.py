"""Runs over REST, and what they measured."""

import csv
import io
import json
import math
from datetime import datetime
from itertools import pairwise
from typing import Any

import pytest
from starlette.testclient import TestClient

from algorithms.presets import preset
from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import train

Json = dict[str, Any]


def submitted(client: TestClient, body: Json) -> str:
    sweep_id: str = client.post("/api/v1/sweeps", json=body).json()["id"]
    return sweep_id


def ascending(*times: str) -> bool:
    """Whether times follow each other; as texts they do not, for whole seconds have no fraction."""
    return all(a <= b for a, b in pairwise(map(datetime.fromisoformat, times)))


def test_a_run_says_all_about_itself(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client, SWEEP)
    run = client.get(f"/api/v1/runs/{sweep_id}-4").json()
    assert run == run | {
        "id": f"{sweep_id}-4",
        "sweep_id": sweep_id,
        "algorithm": "hybrid-ddpg",
        "environment": "MassPoint",
        "environment_version": 1,
        "seed": 1,
        "weights": {"w1": 0.1, "w2": 0.01},
        "config": preset("hybrid-ddpg", "MassPoint").config,
        "timesteps": 4000,
        "timestep": 0,
        "status": "queued",
        "is_cancelling": False,
        "reason": "",
        "attempt": 0,
        "started_at": None,
        "finished_at": None,
        "fingerprint": None,
    }
    assert run["created_at"].endswith("Z")
    train(store, 5, lambda spec, timestep: -1.0)
    run = client.get(run["links"]["self"]).json()
    assert (run["status"], run["timestep"], run["attempt"]) == ("succeeded", 4000, 1)
    assert ascending(run["created_at"], run["started_at"], run["finished_at"])


def test_runs_are_filtered(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client, SWEEP)
    client.post(f"/api/v1/runs/{sweep_id}-0/cancel")

    def count(query: str) -> int:
        return len(client.get(f"/api/v1/sweeps/{sweep_id}/runs?{query}").json()["items"])

    assert count("") == 12
    assert count("status=cancelled") == 1
    assert count("status=queued&algorithm=ddpg") == 5
    assert count("environment=Pendulum&algorithm=hybrid-ddpg") == 3
    assert count("environment=Pend") == 0


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("status=done", "status"),
        ("algorithm=", "algorithm"),
        ("environment=a%00b", "environment"),
        ("sort=colour", "sort"),
    ],
)
def test_a_wrong_filter_is_refused(client: TestClient, query: str, field: str) -> None:
    sweep_id = submitted(client, SWEEP)
    response = client.get(f"/api/v1/sweeps/{sweep_id}/runs?{query}")
    assert response.status_code == 422
    assert [error["field"] for error in response.json()["errors"]] == [field]


def test_pages_of_runs(client: TestClient) -> None:
    sweep_id = submitted(client, SWEEP)
    url, seen = f"/api/v1/sweeps/{sweep_id}/runs?limit=5&environment=Pendulum", []
    while url:
        response = client.get(url)
        seen += [run["id"] for run in response.json()["items"]]
        link = response.headers.get("link", "")
        url = link[1 : link.find(">")]
    assert seen == [f"{sweep_id}-{ordinal}" for ordinal in range(6, 12)]


@pytest.mark.parametrize(
    ("query", "order"),
    [
        ("", [0, 1, 2, 3]),
        ("descending=true", [3, 2, 1, 0]),
        ("sort=return_mean", [1, 0, 2, 3]),
        ("sort=return_mean&descending=true", [2, 0, 1, 3]),
        ("sort=timestep&descending=true", [0, 1, 2, 3]),
    ],
)
def test_runs_are_sorted_and_paged(
    client: TestClient, store: Store, query: str, order: list[int]
) -> None:
    sweep_id = submitted(
        client, changed(seeds=4, algorithms=[{"name": "ddpg"}], environments=["Pendulum"])
    )
    client.post(f"/api/v1/runs/{sweep_id}-3/cancel")
    train(store, 5, lambda spec, timestep: [-2.0, -3.0, 5.0][spec.seed] * timestep)
    url, seen = f"/api/v1/sweeps/{sweep_id}/runs?limit=1&{query}", []
    while url:
        response = client.get(url)
        seen += [int(run["id"].rpartition("-")[2]) for run in response.json()["items"]]
        link = response.headers.get("link", "")
        url = link[1 : link.find(">")]
    assert seen == order


def test_sparklines_end_with_the_latest(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client, changed(seeds=1, environments=["Pendulum"]))
    train(store, 5, lambda spec, timestep: float(timestep) if timestep < 4000 else math.nan)
    url = f"/api/v1/sweeps/{sweep_id}/runs"
    assert client.get(url).json()["items"][0]["sparkline"] is None
    (first, _) = client.get(f"{url}?sparkline=3").json()["items"]
    assert first["sparkline"] == [800.0, 2400.0, None]


def test_attempts_say_how_they_ended(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client, changed(seeds=1, environments=["Pendulum"]))
    url = f"/api/v1/runs/{sweep_id}-0/attempts"
    assert client.get(url).json() == []
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    store.fail(claim, "ValueError: no", "the last line")
    (attempt,) = client.get(url).json()
    assert attempt["outcome"] == "failed"
    assert (attempt["worker"], attempt["error"]) == ("worker", "ValueError: no")
    assert attempt["log_tail"] == "the last line"
    assert ascending(attempt["started_at"], attempt["ended_at"])


def test_cancelling_one_run(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client, changed(seeds=2, algorithms=[{"name": "ddpg"}]))
    for _ in range(2):
        response = client.post(f"/api/v1/runs/{sweep_id}-0/cancel")
        assert response.status_code == 202
        assert response.json()["status"] == "cancelled"
    train(store, 5, lambda spec, timestep: -1.0)
    refusal = client.post(f"/api/v1/runs/{sweep_id}-1/cancel")
    assert refusal.status_code == 409
    assert refusal.headers["content-type"] == "application/problem+json"
    assert "succeeded" in refusal.json()["detail"]
    assert client.get(f"/api/v1/runs/{sweep_id}-0").json()["status"] == "cancelled"
    assert client.post(f"/api/v1/sweeps/{sweep_id}/cancel").status_code == 409


def test_cancelling_a_running_run_says_so(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client, changed(seeds=1, environments=["Pendulum"]))
    store.claim_cohort("worker", 60.0)
    answer = client.post(f"/api/v1/runs/{sweep_id}-0/cancel").json()
    assert (answer["status"], answer["is_cancelling"]) == ("running", True)
    assert answer["reason"]


@pytest.mark.parametrize("run_id", ["nope", f"{'0' * 12}-0", "x-y-z", "%00", "0" * 999, "a-1e3"])
@pytest.mark.parametrize("part", ["", "/measurements", "/attempts"])
def test_an_unknown_run_is_not_found(idle_client: TestClient, run_id: str, part: str) -> None:
    assert idle_client.get(f"/api/v1/runs/{run_id}{part}").status_code == 404


VALUES = [-1203.523456789012345, math.nan, math.inf, -math.inf, 5e-324, 1.7e308]


def exact(client: TestClient, store: Store) -> str:
    """A run that measured every kind of number."""
    sweep_id = submitted(client, changed(seeds=1, environments=["Pendulum"]))
    train(store, len(VALUES), lambda spec, timestep: VALUES[timestep // 800 - 1])
    return f"/api/v1/runs/{sweep_id}-0/measurements"


def test_measurements_are_exact_in_json(client: TestClient, store: Store) -> None:
    response = client.get(exact(client, store))
    table = json.loads(response.text, parse_constant=pytest.fail)
    columns = table["columns"]
    assert list(columns)[:3] == ["timestep", "return_mean", "return_history"]
    assert columns["timestep"] == [800 * (k + 1) for k in range(len(VALUES))]
    shown = [value if math.isfinite(value) else None for value in VALUES]
    assert columns["return_mean"] == shown
    told = {(each["column"], each["timestep"]): each["value"] for each in table["nonfinite"]}
    assert told["return_mean", 1600] == "NaN"
    assert told["return_history", 2400] == "Infinity"
    assert told["return_mean", 3200] == "-Infinity"
    assert told["critic_loss", 3200] == "Infinity"


@pytest.mark.parametrize(
    ("query", "accept"), [("?format=csv", "*/*"), ("", "text/csv"), ("?format=csv", "text/html")]
)
def test_measurements_are_exact_in_csv(
    client: TestClient, store: Store, query: str, accept: str
) -> None:
    response = client.get(exact(client, store) + query, headers={"Accept": accept})
    assert response.headers["content-type"].startswith("text/csv")
    assert response.headers["content-disposition"].endswith('.csv"')
    rows = list(csv.DictReader(io.StringIO(response.text)))
    found = [float(row["return_mean"]) for row in rows]
    assert [repr(value) for value in found] == [repr(value) for value in VALUES]
    assert [int(row["timestep"]) for row in rows] == [800 * (k + 1) for k in range(len(VALUES))]


def test_nothing_measured_is_an_empty_table(client: TestClient) -> None:
    sweep_id = submitted(client, SWEEP)
    url = f"/api/v1/runs/{sweep_id}-0/measurements"
    assert client.get(url).json()["columns"]["timestep"] == []
    assert client.get(f"{url}?format=csv").text.strip().startswith("timestep,return_mean")


def test_runs_are_sorted_by_their_score_on_one_scale(reader: TestClient, trained: str) -> None:
    link = f"{trained}/runs?sort=score&descending=true&limit=5"
    found: list[float] = []
    pages = 0
    while link:
        page = reader.get(link)
        found += [run["score"] for run in page.json()["items"]]
        link = page.links.get("next", {}).get("url", "")
        pages += 1
    assert pages > 1
    assert found == sorted(found, reverse=True)
    assert max(found) <= 1.5  # normalised: raw returns of Pendulum are below -100
    assert min(found) >= -1.5
