"""`d3pg demo`, but for the service that it starts."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from service.cli.host import demo
from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command
from tests.service.training import at_work, rising, train


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch, service: Client) -> Client:
    """A client of the service that stands for the demo's own."""

    @contextmanager
    def own_service() -> Iterator[tuple[Client, None]]:
        yield service, None

    monkeypatch.setattr(demo, "own_service", own_service)
    return service


def test_for_programs_it_is_lines_of_json(d3pg: Command, started: Client, store: Store) -> None:
    with at_work(lambda: train(store, 2, rising)):
        shown = d3pg("demo", "--once", "--json")
    found, *changes = map(json.loads, shown.stdout.splitlines())
    [sweep] = started.sweeps()
    assert found["sweep"] == sweep.id
    assert found["link"].startswith(f"{started.url.rsplit(':', 1)[0]}")
    assert changes[-1]["status"] == "finished"
    assert "Starting the service" in shown.stderr


def test_for_people_it_is_a_link(d3pg: Command, started: Client, store: Store) -> None:
    with at_work(lambda: train(store, 2, rising)):
        shown = d3pg("demo", "--once").stdout
    assert "The curves, live:  http://" in shown
    assert "16 succeeded" in shown
