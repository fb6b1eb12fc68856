"""A PostgreSQL that is restarted under load: users notice a pause, and nothing is lost or doubled.

Every writer keeps what it was told; in the end the database holds that and nothing else.
"""

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor

import psycopg
import pytest
from sqlalchemy.exc import IntegrityError, OperationalError

from service.store.refusal import DatabaseInUseError
from service.store.store import Store
from service.store.upkeep.outage import is_outage, outlasting
from tests.service.store.conftest import Fresh
from tests.service.store.postgresql import PostgreSQL, running_postgresql
from workers.messages.run_spec import RunSpec

WRITERS = 4
LONGEST_PAUSE_SECONDS = 10.0
SPECS = [RunSpec("ddpg", "Pendulum", seed) for seed in range(8)]


@pytest.fixture(scope="module")
def server() -> Iterator[PostgreSQL]:
    """A server that keeps its promises when it dies."""
    with running_postgresql("fsync=on") as running:
        yield running


def create_sweep(store: Store) -> str:
    versions = {"Pendulum": 1}
    return store.create_sweep("x", 0, {}, SPECS, environment_versions=versions).id


class Load:
    """Threads that submit sweeps and read them back until they are told to stop."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.told: list[str] = []
        self.longest_pause = 0.0
        self._stopping = threading.Event()
        self._pool = ThreadPoolExecutor(WRITERS)
        self._writers: list[Future[None]] = [self._pool.submit(self._work) for _ in range(WRITERS)]

    def _work(self) -> None:
        while not self._stopping.is_set():
            begun = time.monotonic()
            sweep_id = create_sweep(self.store)
            assert self.store.find_sweep(sweep_id) is not None
            self.longest_pause = max(self.longest_pause, time.monotonic() - begun)
            self.told.append(sweep_id)

    def wait_for(self, more: int) -> None:
        """Wait until so many more sweeps were acknowledged."""
        wanted = len(self.told) + more
        while len(self.told) < wanted:
            assert not any(writer.done() for writer in self._writers), "a writer saw an error"
            time.sleep(0.01)

    def stop(self) -> None:
        self._stopping.set()
        for writer in self._writers:
            writer.result()
        self._pool.shutdown()


def keeps_its_word(server: PostgreSQL, times: int, disturb: Callable[[PostgreSQL], None]) -> None:
    store = Store.open(server.create("d3pg"))
    load = Load(store)
    for _ in range(times):
        load.wait_for(20)
        disturb(server)
    load.wait_for(20)
    load.stop()
    kept = {sweep.id: sweep.runs.total for sweep in store.list_sweeps(limit=100_000)}
    events = [event for event in store.events_after(0, limit=100_000) if event.kind == "sweep"]
    store.close()
    server.execute("DROP DATABASE d3pg")
    assert set(kept) == set(load.told)
    assert set(kept.values()) == {len(SPECS)}
    assert len(events) == len(kept)
    assert load.longest_pause < LONGEST_PAUSE_SECONDS


def cut(server: PostgreSQL) -> None:
    ends = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = 'd3pg'"
    server.execute(ends)


def crash(server: PostgreSQL) -> None:
    server.crash()
    server.start()


def test_connections_that_are_cut_cost_a_pause(server: PostgreSQL) -> None:
    keeps_its_word(server, 5, cut)


def test_a_crash_costs_a_pause(server: PostgreSQL) -> None:
    keeps_its_word(server, 1, crash)


@pytest.mark.slow
@pytest.mark.parametrize(("times", "disturb"), [(20, crash), (200, cut)])
def test_many_disturbances(
    server: PostgreSQL, times: int, disturb: Callable[[PostgreSQL], None]
) -> None:
    keeps_its_word(server, times, disturb)


def test_an_outage_that_lasts_is_reported(server: PostgreSQL) -> None:
    store = Store.open(server.create("outage"))
    server.stop()
    with pytest.raises(OperationalError) as raised:
        outlasting(lambda: store._reader._once(lambda c: c.exec_driver_sql("SELECT 1")), 0.3)
    assert is_outage(raised.value)
    store.close()
    server.start()


def test_other_errors_are_no_outage() -> None:
    full = OperationalError("INSERT", {}, Exception("database or disk is full"))
    assert not is_outage(full)
    assert not is_outage(OperationalError("INSERT", {}, psycopg.errors.DiskFull()))
    assert not is_outage(IntegrityError("INSERT", {}, psycopg.errors.UniqueViolation()))
    assert is_outage(OperationalError("", {}, psycopg.errors.AdminShutdown()))
    assert is_outage(OperationalError("", {}, psycopg.OperationalError("connection refused")))


def test_a_database_has_one_service(
    fresh_postgresql: Fresh, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.store.connection.CONNECT_SECONDS", 1)
    url = fresh_postgresql()
    store = Store.open(url)
    with pytest.raises(DatabaseInUseError, match="another service works on this database"):
        Store.open(url)
    store.close()
    Store.open(url).close()
