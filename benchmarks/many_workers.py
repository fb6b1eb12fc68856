"""Many workers: what one service costs a run, and how many workers it can serve.

The workers are pretended, 10, 100 and 1,000 of them; the dispatcher, the scheduler and the store
are real, with 100,000 runs queued, on SQLite and on PostgreSQL. Each worker has 16 runs of 50
measurements and reports once a second, a measurement of every run each time, as a real one does.

What counts is processor time (see simulated/processor_time.py): the service's threads, and
PostgreSQL's sessions. It is not seconds of this machine, which may have other work; those are
printed as the most that it can be. A worker's time is lost while it waits for a cohort or for its
news to be taken in. The service is saturated where a second's reports cost a second.
"""

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from benchmarks.simulated.pool import POINTS, PretendedPool
from benchmarks.simulated.processor_time import ProcessorTime
from service.dispatch import Dispatcher
from service.scheduler import DispatchTimes
from service.store.store import Store
from tests.service.store.postgresql import running_postgresql
from workers.run_spec import COHORT_LIMIT, RunSpec

WORKERS = (10, 100, 1000)
QUEUED = 100_000
SWEEPS = 5
REPORTS = 3000
"""At least so many are measured, and five of each worker."""
TIMES = DispatchTimes(lease=3600.0)  # in the database's time, which is this machine's


@dataclass(frozen=True)
class Spent:
    """What had been spent, and what was had for it."""

    simulated: float
    service: float
    database: float
    wall: float
    rounds: int
    reports: int
    runs: int
    lost: float

    def since(self, earlier: "Spent") -> "Spent":
        mine, theirs = vars(self), vars(earlier)
        return Spent(**{name: mine[name] - theirs[name] for name in mine})

    @property
    def processor(self) -> float:
        return self.service + self.database


class Bench:
    """A dispatcher with a store of its own and so many workers."""

    def __init__(self, store: Store, postgres: int | None, workers: int) -> None:
        self.time = ProcessorTime(postgres)
        self.pool = PretendedPool(workers, self.time)
        self.dispatcher = Dispatcher(store, self.pool, TIMES, lambda: self.pool.now)
        self.rounds = 0

    def work(self, reports: int) -> None:
        """Work until so many reports have been taken in."""
        while self.pool.taken < reports:
            self.dispatcher.work_round()
            self.rounds += 1

    @property
    def spent(self) -> Spent:
        pool = self.pool
        lost = pool.lost + pool.waiting()
        service, database = self.time.service, self.time.database
        return Spent(
            pool.now, service, database, time.perf_counter(), self.rounds, pool.taken, pool.ended,
            lost,
        )  # fmt: skip


def main() -> None:
    """Print every figure of both databases."""
    for workers in WORKERS:
        with tempfile.TemporaryDirectory() as folder:
            url = f"sqlite:///{Path(folder) / 'd3pg.sqlite'}"
            measure(f"SQLite, {workers:,} workers", url, None, workers)
    with running_postgresql("fsync=on") as server:
        for workers in WORKERS:
            url = server.create(f"d3pg_{workers}")
            measure(f"PostgreSQL, {workers:,} workers", url, server.process_id, workers)


def measure(name: str, url: str, postgres: int | None, workers: int) -> None:
    """Measure so many workers with a database that is empty at first."""
    store = Store.open(url)
    submit(store)
    bench = Bench(store, postgres, workers)
    bench.work(1)
    while bench.pool.idle:
        bench.work(bench.pool.taken + 1)
    report(f"{name}, until each had its first cohort", bench.pool.now, "s")
    bench.work(bench.pool.taken + workers)
    before = bench.spent
    bench.work(bench.pool.taken + max(REPORTS, 5 * workers))
    print_spent(name, bench.spent.since(before), workers)
    report(f"{name}, longest wait of a worker", bench.pool.longest, "s")
    store.close()


def print_spent(name: str, spent: Spent, workers: int) -> None:
    milliseconds = 1000 * spent.processor
    report(f"{name}, reports a round", spent.reports / spent.rounds, "")
    report(f"{name}, processor time a round", milliseconds / spent.rounds, "ms")
    report(f"{name}, processor time a report", milliseconds / spent.reports, "ms")
    report(
        f"{name}, processor time a run", milliseconds / spent.reports * POINTS / COHORT_LIMIT, "ms"
    )
    report(
        f"{name}, the database's sessions' share of it", 100 * spent.database / spent.processor, "%"
    )
    report(f"{name}, busy", 100 * spent.processor / spent.simulated, "%")
    report(f"{name}, a worker's time lost", 100 * spent.lost / spent.simulated / workers, "%")
    reports = spent.reports / spent.processor
    report(f"{name}, saturated at reports", reports, "1/s")
    report(f"{name}, saturated at runs", reports * COHORT_LIMIT / POINTS, "1/s")
    report(f"{name}, wall time a report, at most", 1000 * spent.wall / spent.reports, "ms")


def submit(store: Store) -> None:
    """Queue all runs, in several sweeps."""
    cells = QUEUED // SWEEPS // COHORT_LIMIT
    specs = [
        RunSpec("ddpg", "Pendulum", seed, (float(cell), 0.0))
        for cell in range(cells)
        for seed in range(COHORT_LIMIT)
    ]
    for sweep in range(SWEEPS):
        store.create_sweep(f"sweep {sweep}", 0, {}, specs, environment_versions={"Pendulum": 1})


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.3g} {unit}".rstrip(), flush=True)


if __name__ == "__main__":
    main()
