"""Users of every scope, and clients that call with their tokens."""

from collections.abc import Callable

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.model.caller import Scope
from tests.service.conftest import client_of

As = Callable[[str, Scope], TestClient]


@pytest.fixture
def called(app: FastAPI) -> As:
    """Make a user of a name and a scope, and return a client with its token."""

    def client(name: str, scope: Scope) -> TestClient:
        return client_of(app, app.state.register.add_user(name, scope))

    return client
