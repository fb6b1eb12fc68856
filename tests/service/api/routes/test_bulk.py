"""Many moves in one request, and deleting."""

from typing import Any

import pytest
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import SWEEP
from tests.service.training import rising, train

Json = dict[str, Any]


def submitted(client: TestClient) -> str:
    sweep_id: str = client.post("/api/v1/sweeps", json=SWEEP).json()["id"]
    return sweep_id


def test_each_is_moved_or_refused_with_its_reason(client: TestClient, store: Store) -> None:
    done = submitted(client)
    train(store, 5, rising)
    waiting, other = submitted(client), submitted(client)
    ids = [waiting, f"{other}-3", f"{done}-0", "nope", done]
    answer = client.post("/api/v1/moves", json={"move": "cancel", "ids": ids})
    assert answer.status_code == 202
    assert answer.json()["moved"] == [waiting, f"{other}-3"]
    reasons = {each["id"]: each["reason"] for each in answer.json()["refused"]}
    assert list(reasons) == [f"{done}-0", "nope", done]
    assert "has already succeeded" in reasons[f"{done}-0"]
    assert "there is no sweep" in reasons["nope"]
    assert client.get(f"/api/v1/sweeps/{waiting}").json()["status"] == "cancelled"
    assert client.get(f"/api/v1/sweeps/{other}").json()["runs"]["cancelled"] == 1


def test_many_are_archived_and_deleted(client: TestClient, store: Store) -> None:
    first, second = submitted(client), submitted(client)
    train(store, 5, rising)
    training = submitted(client)
    asked = {"move": "archive", "ids": [first, f"{second}-0"]}
    answer = client.post("/api/v1/moves", json=asked).json()
    assert answer["moved"] == [first]
    assert "only sweeps" in answer["refused"][0]["reason"]
    assert client.get(f"/api/v1/sweeps/{first}").json()["archived"]
    asked = {"move": "delete", "ids": [first, second, training]}
    answer = client.post("/api/v1/moves", json=asked).json()
    assert answer["moved"] == [first, second]
    assert "cancel it first" in answer["refused"][0]["reason"]
    left = client.get("/api/v1/sweeps?archived=all").json()["items"]
    assert [each["id"] for each in left] == [training]


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"move": "explode", "ids": ["a"]}, "move"),
        ({"move": "cancel", "ids": []}, "ids"),
        ({"move": "cancel", "ids": ["a", "a"]}, "ids"),
        ({"move": "cancel", "ids": [7]}, "ids[0]"),
        ({"move": "cancel", "ids": [str(i) for i in range(1001)]}, "ids"),
        ({"ids": ["a"]}, "move"),
    ],
)
def test_bad_requests_are_refused_by_field(idle_client: TestClient, body: Json, field: str) -> None:
    answer = idle_client.post("/api/v1/moves", json=body)
    assert answer.status_code == 422
    assert [error["field"] for error in answer.json()["errors"]] == [field]


def test_a_sweep_is_deleted_once_it_has_ended(client: TestClient, store: Store) -> None:
    sweep_id = submitted(client)
    link = f"/api/v1/sweeps/{sweep_id}"
    refused = client.delete(link)
    assert refused.status_code == 409
    assert "12 runs that have not ended: cancel it first" in refused.json()["detail"]
    train(store, 5, rising)
    answer = client.delete(link)
    assert (answer.status_code, answer.json()) == (202, {"id": sweep_id, "runs": 12})
    for method, path in (
        ("GET", link),
        ("DELETE", link),
        ("GET", f"{link}/curves"),
        ("GET", f"/api/v1/runs/{sweep_id}-0"),
        ("POST", f"{link}/cancel"),
        ("PATCH", link),
    ):
        assert client.request(method, path, json={}).status_code == 404, (method, path)
