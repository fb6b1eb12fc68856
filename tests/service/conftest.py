"""A service on a new, empty SQLite, and a signed-in client of it."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
import structlog
from fastapi import FastAPI
from pydantic import SecretStr
from starlette.testclient import TestClient

from service.api.app import create_app
from service.api.diagnoser import Diagnoser
from service.settings import Settings
from service.store.store import Store
from tests.service.same_process import SameProcess

TOKEN = "token-of-the-tests-000000"  # noqa: S105
BASE_URL = "http://127.0.0.1:8000"
SWEEP: dict[str, Any] = {
    "name": "small",
    "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg", "weights": {"w1": 0.1, "w2": 0.01}}],
    "environments": ["MassPoint", "Pendulum"],
    "seeds": 3,
    "timesteps": 4000,
}


def changed(**fields: Any) -> dict[str, Any]:
    return {**SWEEP, **fields}


def algorithm(**fields: Any) -> dict[str, Any]:
    return changed(algorithms=[{"name": "hybrid-ddpg", **fields}])


@dataclass
class FakeDispatcher:
    """A cluster that is ready, until a test says otherwise."""

    problem: str | None = None
    workers: dict[str, bool] = field(default_factory=lambda: {"one": False, "two": True})


@pytest.fixture(autouse=True, scope="session")
def _quiet_log() -> None:
    """Print no requests, and no exceptions with all their variables: that takes seconds each."""
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))


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
    app = create_app(settings, store, dispatcher)
    app.state.side = SameProcess()
    app.state.diagnoser = Diagnoser(
        store, settings.checkpoint_place, SameProcess(), app.state.shelf
    )
    return app


@contextmanager
def app_in(folder: Path) -> Iterator[FastAPI]:
    """A service with its data in a folder, for as long as the block."""
    settings = Settings(data_dir=folder, token=SecretStr(TOKEN))
    store = Store.open(settings.store_url)
    yield create_app(settings, store, FakeDispatcher())
    store.close()


def client_of(app: FastAPI, token: str = TOKEN) -> TestClient:
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    return TestClient(app, base_url=BASE_URL, headers=headers, follow_redirects=False)


@pytest.fixture
def stranger(app: FastAPI) -> TestClient:
    """A client without the token."""
    return client_of(app, token="")


@pytest.fixture
def client(app: FastAPI) -> TestClient:
    """A client with the token."""
    return client_of(app)


@pytest.fixture(scope="session")
def idle_app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FastAPI]:
    """A service that no test changes: for the many tests of what is refused."""
    with app_in(tmp_path_factory.mktemp("idle")) as app:
        yield app


@pytest.fixture(scope="session")
def idle_client(idle_app: FastAPI) -> TestClient:
    """A client of it with the token."""
    return client_of(idle_app)


@pytest.fixture
def idle_stranger(idle_app: FastAPI) -> TestClient:
    """A client of it without the token; it keeps cookies, so every test gets its own."""
    return client_of(idle_app, token="")
