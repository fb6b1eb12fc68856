"""A submission under an Idempotency-Key happens once, however often it is sent."""

from itertools import count
from typing import Any

import pytest
from fastapi import FastAPI
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import Connection, event
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import BASE_URL, TOKEN, changed


def post(client: TestClient, key: str, **fields: Any) -> Any:
    body = changed(**{"seeds": 1, "algorithms": [{"name": "ddpg"}], **fields})
    return client.post(
        "/api/v1/sweeps", json=body, headers=[(b"Idempotency-Key", key.encode("latin-1"))]
    )


def test_the_same_again_is_the_same_sweep(client: TestClient, store: Store) -> None:
    first, again = post(client, "a"), post(client, "a")
    assert (first.status_code, again.status_code) == (202, 202)
    assert again.headers["location"] == first.headers["location"]
    assert again.json() == first.json()
    assert len(store.list_sweeps()) == 1


def test_an_answer_shows_the_sweep_as_it_is_by_then(client: TestClient) -> None:
    client.post(post(client, "a").json()["links"]["pause"])
    assert post(client, "a").json()["status"] == "paused"


def test_the_same_key_with_another_sweep_is_refused(client: TestClient, store: Store) -> None:
    sweep = post(client, "a").json()
    refused = post(client, "a", priority=1)
    assert refused.status_code == 422
    [error] = refused.json()["errors"]
    assert error["field"] == "Idempotency-Key"
    assert sweep["id"] in error["message"]
    assert len(store.list_sweeps()) == 1


def test_without_a_key_every_submission_is_new(client: TestClient, store: Store) -> None:
    for _ in range(2):
        assert client.post("/api/v1/sweeps", json=changed()).status_code == 202
    assert len(store.list_sweeps()) == 2


@pytest.mark.parametrize("key", ["", "x" * 256, "caf\xe9", "tab\there"])
def test_a_wrong_key_is_refused(idle_client: TestClient, key: str) -> None:
    response = post(idle_client, key)
    assert response.status_code == 422
    assert [error["field"] for error in response.json()["errors"]] == ["idempotency-key"]


def test_a_server_that_dies_before_it_answers_made_one_sweep(app: FastAPI, store: Store) -> None:
    """The commit happens and its answer is never sent; the client asks again."""
    client = TestClient(
        app,
        base_url=BASE_URL,
        headers={"Authorization": f"Bearer {TOKEN}"},
        raise_server_exceptions=False,
    )

    @event.listens_for(store._writer_engine, "commit", once=True)
    def die(connection: Connection) -> None:
        connection.exec_driver_sql("COMMIT")
        raise RuntimeError("killed")

    assert post(client, "a").status_code == 500
    [made] = store.list_sweeps()
    assert post(client, "a").json()["id"] == made.id
    assert [sweep.id for sweep in store.list_sweeps()] == [made.id]


keys = st.sampled_from(["a", "b", "a b", '"quoted"'])
numbers = st.integers(0, 2)
examples = count()


@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(sent=st.lists(st.tuples(keys, numbers), max_size=8))
def test_any_order_of_submissions(client: TestClient, sent: list[tuple[str, int]]) -> None:
    """The first request under a key decides what it stands for."""
    example = next(examples)  # the service is not a new one: the keys are
    made: dict[str, tuple[int, str]] = {}
    for key, priority in sent:
        response = post(client, f"{key} {example}", priority=priority)
        if key not in made:
            made[key] = (priority, response.json()["id"])
        first_priority, sweep_id = made[key]
        if priority == first_priority:
            assert (response.status_code, response.json()["id"]) == (202, sweep_id)
        else:
            assert response.status_code == 422
    assert len({sweep_id for _, sweep_id in made.values()}) == len(made)
