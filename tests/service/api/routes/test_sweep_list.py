"""The list of sweeps: what a row shows, what finds it, and what is written about a sweep."""

from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import RANDOM, random_return, rising, train

SWEEPS = "/api/v1/sweeps"
Json = dict[str, Any]


def submitted(client: TestClient, **fields: Any) -> str:
    sweep_id: str = client.post(SWEEPS, json=changed(**fields)).json()["id"]
    return sweep_id


def found(client: TestClient, query: str) -> list[str]:
    answer = client.get(f"{SWEEPS}?{query}")
    assert answer.status_code == 200, answer.text
    return [item["id"] for item in answer.json()["items"]]


def test_a_row_names_what_is_compared_and_the_best_curve(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client, environments=["Pendulum", "MassPoint"], tags=["paper"])
    [row] = client.get(SWEEPS).json()["items"]
    assert row["algorithms"] == ["ddpg", "hybrid-ddpg"]
    assert row["environments"] == ["Pendulum", "MassPoint"]
    assert (row["entry_count"], row["seeds"], row["tags"]) == (2, 3, ["paper"])
    assert row["best"] is None
    assert row.keys().isdisjoint({"request", "entries", "notes"})
    for environment in ("MassPoint", "Pendulum"):
        store.record_random_return(random_return(environment, RANDOM))
    train(store, 5, rising)
    [row] = client.get(SWEEPS).json()["items"]
    table = client.get(f"{SWEEPS}/{sweep_id}/table").json()
    cells = {
        (line["label"], environment): entry["mean"]
        for line in table["rows"]
        for environment, entry in zip(table["environments"], line["entries"], strict=True)
    }
    best = row["best"]
    assert cells[best["label"], best["environment"]] == max(cells.values())
    assert best["score"] == pytest.approx(max(cells.values()))
    assert best["sparkline"][-1] == pytest.approx(best["score"])
    assert len(best["sparkline"]) == 5


def test_a_curve_with_a_run_that_did_not_end_well_is_not_the_best(
    client: TestClient, store: Store
) -> None:
    store.record_random_return(random_return("Pendulum", RANDOM))
    submitted(client, environments=["Pendulum"], algorithms=[{"name": "ddpg"}])
    claim = store.claim_cohort("w", 60.0, limit=1)
    assert claim is not None
    store.fail(claim, "ValueError: no")
    train(store, 5, rising)
    [row] = client.get(SWEEPS).json()["items"]
    assert row["runs"]["succeeded"] == 2
    assert row["best"] is None


def test_sweeps_are_found_by_what_they_are(client: TestClient, store: Store) -> None:
    first = submitted(client, name="Longer 50% horizon", tags=["paper", "die"])
    second = submitted(client, name="x", notes="See *the* paper", algorithms=[{"name": "sac"}])
    third = submitted(client, name="y", environments=["CartPole"], tags=["paper"])
    assert found(client, "q=HORIZON") == [first]
    assert found(client, "q=50%25") == [first]
    assert found(client, "q=_") == []
    assert found(client, "q=paper") == [third, second, first]
    assert found(client, f"q={second[:6]}") == [second]
    assert found(client, "tag=paper") == [third, first]
    assert found(client, "tag=die") == [first]
    assert found(client, "tag=nope") == []
    assert found(client, "algorithm=sac") == [second]
    assert found(client, "environment=CartPole&algorithm=ddpg") == [third]
    assert found(client, "environment=CartPole&algorithm=sac") == []
    page = client.get(f"{SWEEPS}?tag=paper&limit=1").json()
    assert found(client, f"tag=paper&limit=1&after={page['next']}") == [first]


def test_sweeps_are_found_by_their_status(client: TestClient, store: Store) -> None:
    """By the same status that they show."""
    train_me, cut = submitted(client, seeds=1), submitted(client, seeds=1)
    cut_late = submitted(client, seeds=[4])
    train(store, 5, rising)
    client.post(f"{SWEEPS}/{cut}/cancel")
    began, paused = submitted(client, seeds=1), submitted(client, seeds=1)
    client.post(f"{SWEEPS}/{paused}/pause")
    store.claim_cohort("w", 60.0, limit=1)
    waiting, half = submitted(client, seeds=1), submitted(client, seeds=1)
    for run in range(4):
        client.post(f"/api/v1/runs/{half}-{run}/pause")
    stopped = submitted(client, seeds=1)
    client.post(f"{SWEEPS}/{stopped}/cancel")
    shown = {item["id"]: item["status"] for item in client.get(SWEEPS).json()["items"]}
    assert shown == {
        train_me: "finished",
        cut: "finished",
        cut_late: "finished",
        began: "running",
        paused: "paused",
        waiting: "queued",
        half: "paused",
        stopped: "cancelled",
    }
    for status in set(shown.values()):
        expected = {sweep_id for sweep_id, its in shown.items() if its == status}
        assert set(found(client, f"status={status}")) == expected


def test_archived_sweeps_are_out_of_the_way(client: TestClient) -> None:
    kept, archived = submitted(client), submitted(client)
    assert client.patch(f"{SWEEPS}/{archived}", json={"archived": True}).json()["archived"]
    assert found(client, "") == [kept]
    assert found(client, "archived=true") == [archived]
    assert set(found(client, "archived=all")) == {kept, archived}
    client.patch(f"{SWEEPS}/{archived}", json={"archived": False})
    assert set(found(client, "")) == {kept, archived}


def test_what_is_written_about_a_sweep_is_changed_field_by_field(
    client: TestClient, store: Store
) -> None:
    sweep_id = submitted(client, tags=["a"], priority=3)
    before = store.last_event_id()
    link = f"{SWEEPS}/{sweep_id}"
    answer = client.patch(link, json={"name": "new", "notes": "# N\n\ntext", "tags": ["b", "a"]})
    assert answer.status_code == 200
    shown = client.get(link).json()
    assert shown == answer.json()
    assert (shown["name"], shown["notes"], shown["tags"]) == ("new", "# N\n\ntext", ["b", "a"])
    assert (shown["priority"], shown["archived"]) == (3, False)
    [event] = store.events_after(before)
    assert (event.kind, event.payload["change"]) == ("sweep", "edited")
    assert client.patch(link, json={"name": "new"}).json() == shown
    assert client.patch(link, json={}).json() == shown
    assert store.last_event_id() == event.id
    assert client.patch(link, json={"tags": [], "priority": -5}).json()["tags"] == []
    assert found(client, "tag=a") == []
    assert client.get(link).json()["priority"] == -5


@pytest.mark.parametrize(
    ("edit", "field"),
    [
        ({"name": ""}, "name"),
        ({"name": None}, "name"),
        ({"notes": "x" * 20_001}, "notes"),
        ({"notes": "a\0"}, "notes"),
        ({"tags": "a"}, "tags"),
        ({"tags": ["a", "a"]}, "tags"),
        ({"tags": ["a", " b"]}, "tags[1]"),
        ({"tags": [""]}, "tags[0]"),
        ({"tags": ["x" * 51]}, "tags[0]"),
        ({"tags": [str(i) for i in range(21)]}, "tags"),
        ({"archived": 1}, "archived"),
        ({"priority": 1001}, "priority"),
        ({"status": "finished"}, "status"),
    ],
)
def test_bad_edits_are_refused_by_field(client: TestClient, edit: Json, field: str) -> None:
    sweep_id = submitted(client)
    before = client.get(f"{SWEEPS}/{sweep_id}").json()
    answer = client.patch(f"{SWEEPS}/{sweep_id}", json=edit)
    assert answer.status_code == 422
    assert [error["field"] for error in answer.json()["errors"]] == [field]
    assert client.get(f"{SWEEPS}/{sweep_id}").json() == before


def test_there_is_no_such_sweep_to_edit(client: TestClient) -> None:
    assert client.patch(f"{SWEEPS}/nope", json={"name": "x"}).status_code == 404


@pytest.mark.parametrize(
    "query", ["status=nope", "archived=maybe", "tag=", "algorithm=", "limit=0", "colour=red"]
)
def test_bad_searches_are_refused_by_field(idle_client: TestClient, query: str) -> None:
    answer = idle_client.get(f"{SWEEPS}?{query}")
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["field"].startswith(query.partition("=")[0])


def test_the_same_sweep_is_submitted_with_its_notes_and_tags(client: TestClient) -> None:
    sweep = client.post(SWEEPS, json=SWEEP | {"notes": "n", "tags": ["t"]}).json()
    assert (sweep["notes"], sweep["tags"]) == ("n", ["t"])
    assert (sweep["request"]["notes"], sweep["request"]["tags"]) == ("n", ["t"])


def test_a_webhook_is_posted_changed_and_shown(app: FastAPI, client: TestClient) -> None:
    link = f"{SWEEPS}/{submitted(client, webhook='http://127.0.0.1:9/a')}"
    shown = client.get(link).json()["webhook"]
    assert shown == {"url": "http://127.0.0.1:9/a", "delivered_at": None, "tries": 0, "problem": ""}
    assert client.patch(link, json={"webhook": None}).json()["webhook"] is None
    app.state.webhook_hosts = ("hooks.example.org",)
    for wrong in ("x", "ftp://a/b", "http://169.254.169.254/", "http://127.0.0.1:9/a", 7):
        for answer in (
            client.patch(link, json={"webhook": wrong}),
            client.post(SWEEPS, json=changed(webhook=wrong)),
        ):
            assert answer.status_code == 422
            assert [error["field"] for error in answer.json()["errors"]] == ["webhook"]
    good = client.patch(link, json={"webhook": "https://hooks.example.org/d3pg"})
    assert good.json()["webhook"]["url"] == "https://hooks.example.org/d3pg"
