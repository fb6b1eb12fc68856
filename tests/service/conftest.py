"""A service on a new, empty SQLite, and a signed-in client of it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from pydantic import SecretStr
from starlette.testclient import TestClient

from service.app import create_app
from service.settings import Settings
from service.store.store import Store

TOKEN = "token-of-the-tests-000000"  # noqa: S105
BASE_URL = "http://127.0.0.1:8000"
SWEEP: dict[str, Any] = {
    "name": "small",
    "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg", "weights": {"w1": 0.1, "w2": 0.01}}],
    "environments": ["MassPoint", "Pendulum"],
    "seeds": 3,
    "timesteps": 4000,
}


@dataclass
class FakeDispatcher:
    """A cluster that is ready, until a test says otherwise."""

    problem: str | None = None


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    return Settings(data_dir=tmp_path, token=SecretStr(TOKEN))


@pytest.fixture
def store(settings: Settings) -> Iterator[Store]:
    store = Store.open(settings.store_url)
    yield store
    store.close()


@pytest.fixture
def dispatcher() -> FakeDispatcher:
    return FakeDispatcher()


@pytest.fixture
def app(settings: Settings, store: Store, dispatcher: FakeDispatcher) -> FastAPI:
    return create_app(settings, store, dispatcher)


@pytest.fixture
def stranger(app: FastAPI) -> TestClient:
    """A client without the token."""
    return TestClient(app, base_url=BASE_URL, follow_redirects=False)


@pytest.fixture
def client(app: FastAPI) -> TestClient:
    """A client with the token."""
    headers = {"Authorization": f"Bearer {TOKEN}"}
    return TestClient(app, base_url=BASE_URL, headers=headers, follow_redirects=False)
