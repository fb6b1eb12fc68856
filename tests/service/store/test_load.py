"""Sixteen clients that submit, fifty that read, workers that write, a backup now and then.

On SQLite: no "database is locked", nothing starved, the write-ahead log bounded. Slow.
"""

import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from subprocess import run
from sys import executable

import pytest

from service.store.store import Store
from tests.service.store.conftest import Fresh, measured
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

SECONDS = 120.0
SUBMITTERS, READERS, WORKERS = 16, 50, 2
SWEEPS_EACH = 200  # bounds what is stored
LONGEST_WRITE_SECONDS = 5.0
LARGEST_LOG_BYTES = 128 * 2**20


class Load:
    """What the threads do until time is up, and what they saw."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.end = time.monotonic() + SECONDS
        self.submitted: list[str] = []
        self.longest_write = 0.0
        self.reads = 0

    def submit(self) -> None:
        specs = [RunSpec("ddpg", "Pendulum", seed) for seed in range(16)]
        for _ in range(SWEEPS_EACH):
            begun = time.monotonic()
            if begun > self.end:
                return
            sweep = self.store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
            self.longest_write = max(self.longest_write, time.monotonic() - begun)
            self.submitted.append(sweep.id)
            time.sleep(SECONDS / SWEEPS_EACH / 2)

    def read(self) -> None:
        while time.monotonic() < self.end:
            sweeps = self.store.list_sweeps(limit=20)
            for sweep in sweeps[:2]:
                self.store.list_runs(sweep.id)
                self.store.curves(sweep.id, ["return_mean"])
            self.store.events_after(max(0, self.store.last_event_id() - 100))
            self.reads += 1
            time.sleep(0.2)

    def work(self) -> None:
        while time.monotonic() < self.end:
            if (claim := self.store.claim_cohort("w", 60.0)) is None:
                time.sleep(0.05)
                continue
            seeds = tuple(claimed.spec.seed for claimed in claim.runs)
            points = tuple(measured(seed, 800 * (i + 1)) for i in range(10) for seed in seeds)
            self.store.record(claim, Progress(8000, measurements=points, finished=seeds))


def backup(url: str, file: Path) -> None:
    """From another process, as an operator would."""
    command = [executable, "-m", "service.cli", "db", "backup", str(file), "--database-url", url]
    done = run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_nothing_is_locked_under_load(fresh_sqlite: Fresh, tmp_path: Path) -> None:
    url = fresh_sqlite()
    store = Store.open(url)
    load = Load(store)
    jobs: list[Callable[[], None]] = [
        *[load.submit] * SUBMITTERS,
        *[load.read] * READERS,
        *[load.work] * WORKERS,
    ]
    with ThreadPoolExecutor(len(jobs)) as pool:
        futures = [pool.submit(job) for job in jobs]
        for place in range(4):
            backup(url, tmp_path / f"backup-{place}.sqlite")
            threading.Event().wait(SECONDS / 8)
        for future in futures:
            future.result()  # raises what the thread saw, "database is locked" too
    kept = {sweep.id for sweep in store.list_sweeps(limit=100_000)}
    log = (tmp_path / "d3pg-0.sqlite-wal").stat().st_size
    store.close()
    assert kept == set(load.submitted)
    assert load.longest_write < LONGEST_WRITE_SECONDS
    assert log < LARGEST_LOG_BYTES
