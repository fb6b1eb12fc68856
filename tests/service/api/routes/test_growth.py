"""Adding to a sweep over REST: what is added, what is refused and why."""

from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import rising, train

Json = dict[str, Any]


def submitted(client: TestClient, **fields: Any) -> str:
    link: str = client.post("/api/v1/sweeps", json=changed(**fields)).json()["links"]["self"]
    return link


def refused(client: TestClient, link: str, body: Json) -> dict[str, str]:
    before = client.get(link).json()
    answer = client.post(f"{link}/runs", json=body)
    assert answer.status_code == 422, answer.text
    assert client.get(link).json() | {"eta_seconds": 0} == before | {"eta_seconds": 0}
    return {error["field"]: error["message"] for error in answer.json()["errors"]}


def test_seeds_are_added_to_every_curve(client: TestClient, store: Store) -> None:
    link = submitted(client)
    train(store, 5, rising)
    answer = client.post(f"{link}/runs", json={"seeds": [3, 9]})
    assert answer.status_code == 202
    assert answer.json()["runs"]["queued"] == 8
    assert answer.json()["request"]["seeds"] == [0, 1, 2, 3, 9]
    train(store, 5, rising)
    curves = client.get(f"{link}/curves?seeds=true").json()
    for panel in curves["panels"]:
        for curve in panel["curves"]:
            assert curve["runs"] == 5
    labels = {run["label"] for run in client.get(f"{link}/runs").json()["items"]}
    assert labels == {"ddpg", "hybrid-ddpg"}
    assert client.get(f"{link}/statistics").status_code == 200


def test_entries_are_added_to_every_task(client: TestClient, store: Store) -> None:
    link = submitted(client)
    train(store, 5, rising)
    added = [{"name": "ddpg", "config": {"noise": [0.11, 0.12]}}, {"name": "sac", "label": "soft"}]
    answer = client.post(f"{link}/runs", json={"algorithms": added}).json()
    assert answer["runs"]["queued"] == 3 * 2 * 3
    assert answer["request"]["algorithms"] == [*SWEEP["algorithms"], *added]
    labels = [entry["label"] for entry in answer["entries"]]
    assert labels == ["ddpg", "hybrid-ddpg", "ddpg noise=0.11", "ddpg noise=0.12", "soft"]
    train(store, 5, rising)
    rows = client.get(f"{link}/table?normalized=false").json()["rows"]
    assert [row["label"] for row in rows] == labels
    assert all(entry["n"] == 3 for row in rows for entry in row["entries"])
    again = client.post("/api/v1/sweeps?dry_run=true", json=answer["request"]).json()
    assert again["runs"]["total"] == answer["runs"]["total"]


def test_runs_are_extended(client: TestClient, store: Store) -> None:
    link = submitted(client)
    train(store, 5, rising)
    for _ in range(2):
        answer = client.post(f"{link}/runs", json={"timesteps": 8000})
        assert answer.status_code == 202
        assert answer.json()["runs"]["queued"] == 12
    assert answer.json()["request"]["timesteps"] == 8000
    train(store, 10, rising)
    [curve, *_] = client.get(f"{link}/curves").json()["panels"][0]["curves"]
    assert curve["x"][-1] == 8000
    assert len(curve["x"]) == 10


@pytest.mark.parametrize(
    ("body", "field", "says"),
    [
        ({}, "body", "one of seeds, algorithms and timesteps"),
        ({"seeds": [5], "timesteps": 8000}, "body", "one of seeds, algorithms and timesteps"),
        ({"seeds": [5, 1]}, "seeds[1]", "one of its seeds already"),
        ({"seeds": [5, 5]}, "seeds[1]", "is repeated"),
        ({"seeds": []}, "seeds", "at least 1"),
        ({"seeds": 4}, "seeds", "list"),
        ({"seeds": [-1]}, "seeds[0]", "greater than or equal to 0"),
        ({"seeds": list(range(10, 6000))}, "seeds", "at most 20000"),
        ({"timesteps": 3999}, "timesteps", "more than the 4000"),
        ({"timesteps": 0}, "timesteps", "greater than or equal to 1"),
        ({"algorithms": [{"name": "dppg"}]}, "algorithms[0].name", "did you mean 'ddpg'?"),
        ({"algorithms": [{"name": "ddpg"}]}, "algorithms[0]", "is the same as"),
        (
            {"algorithms": [{"name": "sac"}, {"name": "td3", "config": {"tau": 7}}]},
            "algorithms[1].config.tau",
            "less than or equal to 1",
        ),
        ({"algorithms": [{"name": "sac", "label": "ddpg"}]}, "algorithms[0].label", "called"),
        ({"algorithm": []}, "algorithm", "did you mean 'algorithms'?"),
    ],
)
def test_bad_additions_are_refused_by_field(
    client: TestClient, body: Json, field: str, says: str
) -> None:
    assert says in refused(client, submitted(client), body)[field]


def test_more_timesteps_than_a_worker_has_memory_for(app: FastAPI, client: TestClient) -> None:
    link = submitted(client)
    app.state.worker_memory = 10**6
    assert "a worker may fill" in refused(client, link, {"timesteps": 100_000})["timesteps"]


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"algorithms": [{"name": "ddpg"}, {"name": "ppo"}]}, "Runs of ppo cannot go on"),
        ({"scale": [0.5, 1]}, "differ in their share"),
    ],
)
def test_what_cannot_be_extended_says_why(client: TestClient, fields: Json, says: str) -> None:
    link = submitted(client, **fields)
    answer = client.post(f"{link}/runs", json={"timesteps": 8000})
    assert answer.status_code == 409
    assert says in answer.json()["detail"]


def test_nothing_is_added_to_what_was_cancelled_until_it_is_not(client: TestClient) -> None:
    link = submitted(client)
    client.post(f"{link}/cancel")
    answer = client.post(f"{link}/runs", json={"seeds": [7]})
    assert answer.status_code == 409
    assert "uncancel it first" in answer.json()["detail"]
    assert client.post(f"{link}/uncancel").json()["runs"]["queued"] == 12
    assert client.post(f"{link}/runs", json={"seeds": [7]}).status_code == 202


def test_a_limit_of_workers_is_posted_and_changed(client: TestClient, store: Store) -> None:
    link = submitted(client, max_workers=1)
    assert client.get(link).json()["max_workers"] == 1
    assert store.claim_cohort("one", 60.0) is not None
    assert store.claim_cohort("two", 60.0) is None
    assert client.patch(link, json={"max_workers": None}).json()["max_workers"] is None
    assert store.claim_cohort("two", 60.0) is not None
    for wrong in (0, 4097, "1", 1.5):
        answer = client.patch(link, json={"max_workers": wrong})
        assert answer.json()["errors"][0]["field"] == "max_workers"


@pytest.mark.parametrize(
    ("added", "product", "timesteps"),
    [
        ({"seeds": [3, 9]}, "2 x 2 x 2 seeds = 8 runs", 8 * 4000),
        ({"algorithms": [{"name": "sac"}]}, "1 x 2 x 3 seeds = 6 runs", 6 * 4000),
        ({"timesteps": 10_000}, "2 x 2 x 3 seeds = 12 runs", 12 * 6000),
    ],
)
def test_an_addition_is_told_before_it_is_made(
    client: TestClient, store: Store, added: Json, product: str, timesteps: int
) -> None:
    link = submitted(client)
    train(store, 5, rising)
    before = client.get(link).json()
    answer = client.post(f"{link}/runs", params={"dry_run": True}, json=added)
    assert answer.status_code == 200
    told = answer.json()
    assert told["product"].split(", about")[0] == product
    assert told["timesteps"] == timesteps
    assert told["estimate"]["core_seconds"] > 0
    assert client.get(link).json() == before
    grown = client.post(f"{link}/runs", json=added).json()
    assert grown["runs"]["queued"] == told["runs"]["queued"]


def test_a_dry_run_is_refused_as_the_addition_is(client: TestClient, store: Store) -> None:
    link = submitted(client)
    assert store.claim_cohort("worker", 60.0) is not None
    cancelled = submitted(client)
    client.post(f"{cancelled}/cancel")
    for sweep, added, reason in (
        (link, {"timesteps": 8000}, "are in training"),
        (cancelled, {"seeds": [3]}, "was cancelled"),
    ):
        asked = [
            client.post(f"{sweep}/runs", params={"dry_run": is_dry}, json=added)
            for is_dry in (True, False)
        ]
        assert [answer.status_code for answer in asked] == [409, 409]
        assert [reason in answer.json()["detail"] for answer in asked] == [True, True]
    assert set(refused(client, link, {"seeds": [0]})) == {"seeds[0]"}
    dry = client.post(f"{link}/runs", params={"dry_run": True}, json={"seeds": [0]})
    assert dry.status_code == 422
