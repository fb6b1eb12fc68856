"""Is the process there; can it work."""

from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import FakeDispatcher


def checks(answer: dict[str, Any]) -> dict[str, str | None]:
    return {check["name"]: check["problem"] for check in answer["checks"]}


def test_healthz_needs_no_token_and_no_database(stranger: TestClient, store: Store) -> None:
    store.close()
    assert stranger.get("/healthz").json() == {"status": "ok"}


def test_ready(client: TestClient) -> None:
    response = client.get("/readyz")
    assert response.status_code == 200
    assert response.json()["status"] == "ready"
    assert checks(response.json()) == {"database": None, "cluster": None}


def test_a_cluster_that_starts_is_said_to(client: TestClient, dispatcher: FakeDispatcher) -> None:
    dispatcher.problem = "the cluster is starting"
    response = client.get("/readyz")
    assert response.status_code == 503
    assert checks(response.json())["cluster"] == "the cluster is starting"


def test_a_database_that_fails_is_said_to(
    app: FastAPI, client: TestClient, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    del app
    with store._readers.connect() as connection:
        connection.exec_driver_sql("PRAGMA query_only=OFF")
        connection.exec_driver_sql("DROP TABLE measurements")
        connection.exec_driver_sql("DROP TABLE attempts")
        connection.exec_driver_sql("DROP TABLE runs")
        connection.commit()
    response = client.get("/readyz")
    assert response.status_code == 503
    assert "no such table" in (checks(response.json())["database"] or "")
