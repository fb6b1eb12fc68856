"""Is the process there; can it work."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi import FastAPI
from sqlalchemy import Connection
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


def drop(table: str) -> Callable[[Connection], object]:
    return lambda connection: connection.exec_driver_sql(f"DROP TABLE {table}")


def test_a_database_that_fails_is_said_to(
    app: FastAPI, client: TestClient, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    del app
    for table in ("measurements", "attempts", "runs"):
        store.write(drop(table))
    response = client.get("/readyz")
    assert response.status_code == 503
    assert "no such table" in (checks(response.json())["database"] or "")
