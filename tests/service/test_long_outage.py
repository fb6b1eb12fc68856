"""A database that is away for longer than anybody waits: said so, and forgotten when it is back."""

import time
from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import SecretStr

from service.api.app import create_app
from service.queue.dispatch import Dispatcher
from service.settings import Settings
from service.store.store import Store
from service.store.upkeep.outage import PATIENCE_SECONDS
from tests.service.conftest import TOKEN, client_of
from tests.service.fake_pool import CYCLE, FakePool, measurement_of
from tests.service.store.postgresql import running_postgresql
from workers.messages.run_spec import RunSpec

pytestmark = pytest.mark.slow

TIMESTEPS = 4 * CYCLE


def wait_for(is_so: Callable[[], bool], seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_requests_are_told_to_come_again_and_runs_go_on_by_themselves(tmp_path: Path) -> None:
    with running_postgresql("fsync=on") as server:
        store = Store.open(server.create("d3pg"))
        pool = FakePool()
        pool.is_freezing = True
        dispatcher = Dispatcher(store, pool)
        client = client_of(
            create_app(Settings(data_dir=tmp_path, token=SecretStr(TOKEN)), store, dispatcher)
        )
        specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=TIMESTEPS) for seed in range(4)]
        sweep = store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
        dispatcher.start()
        try:
            wait_for(lambda: all(run.status == "running" for run in store.list_runs(sweep.id)))
            server.stop()
            begun = time.monotonic()
            response = client.get("/api/v1/sweeps")
            assert response.status_code == 503
            assert response.headers["retry-after"] == "5"
            assert PATIENCE_SECONDS <= time.monotonic() - begun < 2 * PATIENCE_SECONDS
            assert client.post(f"/api/v1/sweeps/{sweep.id}/pause").status_code == 503
            assert client.get("/healthz").status_code == 200
            wait_for(lambda: "the database refuses" in (dispatcher.problem or ""))
            for worker in pool.workers.values():
                worker.is_frozen = False
            server.start()
            wait_for(lambda: all(run.status == "succeeded" for run in store.list_runs(sweep.id)))
            assert all(run.attempt == 1 for run in store.list_runs(sweep.id))
            steps = range(CYCLE, TIMESTEPS + 1, CYCLE)
            for run in store.list_runs(sweep.id):
                whole = [measurement_of(run.spec.seed, step) for step in steps]
                assert store.measurements(run.id) == whole
        finally:
            dispatcher.stop()
            store.close()
