"""Moves over REST: pause, resume, retry; and a submission that is sent twice."""

import pytest
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import SWEEP, changed

RUNS = 12


def submitted(client: TestClient) -> str:
    sweep_id: str = client.post("/api/v1/sweeps", json=SWEEP).json()["id"]
    return sweep_id


def test_pausing_and_resuming_a_sweep(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client)
    for _ in range(2):
        answer = client.post(f"/api/v1/sweeps/{sweep_id}/pause")
        assert answer.status_code == 202
        assert (answer.json()["status"], answer.json()["runs"]["paused"]) == ("paused", RUNS)
    listed = client.get(f"/api/v1/sweeps/{sweep_id}/runs?status=paused&limit=100").json()["items"]
    assert len(listed) == RUNS
    assert store.claim_cohort("w", 60.0) is None
    answer = client.post(f"/api/v1/sweeps/{sweep_id}/resume")
    assert (answer.status_code, answer.json()["runs"]["queued"]) == (202, RUNS)


def test_retrying_what_failed(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client)
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    store.fail(claim, "ValueError: no")
    answer = client.post(f"/api/v1/runs/{claim.runs[0].run_id}/retry")
    assert (answer.status_code, answer.json()["status"]) == (202, "queued")
    answer = client.post(f"/api/v1/sweeps/{sweep_id}/retry")
    assert (answer.status_code, answer.json()["runs"]["failed"]) == (202, 0)


@pytest.mark.parametrize("move", ["cancel", "pause", "resume", "retry"])
def test_impossible_moves_say_why(client: TestClient, store: Store, move: str) -> None:
    sweep_id = submitted(client)
    run_id = f"{sweep_id}-0"
    client.post(f"/api/v1/sweeps/{sweep_id}/cancel")
    for path in (f"sweeps/{sweep_id}", f"runs/{run_id}"):
        answer = client.post(f"/api/v1/{path}/{move}")
        if move == "cancel":
            assert answer.status_code == 202
        else:
            assert answer.status_code == 409
            assert answer.headers["content-type"] == "application/problem+json"
            assert "cancelled" in answer.json()["detail"]
    for path in ("sweeps/nope", "runs/nope-0"):
        assert client.post(f"/api/v1/{path}/{move}").status_code == 404


def test_a_submission_sent_twice_is_one_sweep(client: TestClient) -> None:
    key = {"Idempotency-Key": "notebook 7"}
    first = client.post("/api/v1/sweeps", json=SWEEP, headers=key)
    second = client.post("/api/v1/sweeps", json=SWEEP, headers=key)
    assert (first.status_code, second.status_code) == (202, 202)
    assert first.headers["Location"] == second.headers["Location"]
    assert len(client.get("/api/v1/sweeps").json()["items"]) == 1
    other = client.post("/api/v1/sweeps", json=changed(seeds=4), headers=key)
    assert other.status_code == 422
    [fault] = other.json()["errors"]
    assert fault["field"] == "Idempotency-Key"
    assert first.json()["id"] in fault["message"]
    assert client.post("/api/v1/sweeps", json=SWEEP).json()["id"] != first.json()["id"]


@pytest.mark.parametrize("key", ["", "x" * 256])
def test_a_key_has_a_length(client: TestClient, key: str) -> None:
    answer = client.post("/api/v1/sweeps", json=SWEEP, headers={"Idempotency-Key": key})
    assert answer.status_code == 422
    assert client.get("/api/v1/sweeps").json()["items"] == []
