"""A service with one trained sweep, for tests that only read."""

from collections.abc import Iterator

import pytest
from pydantic import SecretStr
from starlette.testclient import TestClient

from service.api.app import create_app
from service.settings import Settings
from service.store.store import Store
from tests.service.conftest import TOKEN, FakeDispatcher, changed, client_of
from tests.service.same_process import SameProcess
from tests.service.training import RANDOM, random_return, rising, train


@pytest.fixture(scope="session")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    """A client of a service with one trained sweep of three seeds; tests only read."""
    settings = Settings(data_dir=tmp_path_factory.mktemp("trained"), token=SecretStr(TOKEN))
    store = Store.open(settings.store_url)
    for environment in ("MassPoint", "Pendulum"):
        store.record_random_return(random_return(environment, RANDOM))
    app = create_app(settings, store, FakeDispatcher())
    app.state.side = SameProcess()
    client = client_of(app)
    client.post("/api/v1/sweeps", json=changed(name="=50% | of"))
    train(store, 5, rising)
    yield client
    store.close()


@pytest.fixture(scope="session")
def trained(reader: TestClient) -> str:
    """The link of that sweep."""
    (sweep,) = reader.get("/api/v1/sweeps").json()["items"]
    return str(sweep["links"]["self"])
