"""Many workers: the service's cost per run, and the number of workers that it can serve.

The workers are simulated, 10, 100 and 1,000 of them; the dispatcher, the scheduler and the store
are real, with 100,000 runs queued, on SQLite and on PostgreSQL. Each worker has 16 runs at once, of
50 measurements, one per second, like a real one on a fast core; it reports as often as required.

The cost is processor time (see simulated/processor_time.py) of the service's threads and of
PostgreSQL's sessions. It is not wall time, since this machine may have other work; wall time is
printed as an upper bound. A worker's time is lost while it waits for a cohort or for its reports to
be processed. The service is saturated when the reports of one second cost one second.

    python -m benchmarks.many_workers [sqlite] [postgresql] [--workers 10 100 1000]
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.simulated.pool import POINTS, PretendedPool
from benchmarks.simulated.processor_time import ProcessorTime
from benchmarks.store import DATABASES
from service.queue.dispatch import Dispatcher
from service.queue.dispatch_state import DispatchTimes
from service.store.store import Store
from tests.service.store.postgresql import running_postgresql
from workers.messages.run_spec import COHORT_LIMIT, RunSpec, Weights

WORKERS = (10, 100, 1000)
QUEUED = 100_000
SWEEPS = 5
REPORTS = 1000
"""The smallest number of reports that are measured; at least three per worker are."""
TIMES = DispatchTimes(lease=3600.0)  # in the database's time, which is this machine's


@dataclass(frozen=True)
class Spent:
    """The seconds spent so far, and the work done in them. `passed` is the workers' time."""

    passed: float
    service: float
    database: float
    wall: float
    waited: float
    rounds: int
    reports: int
    measurements: int
    runs: int

    def since(self, earlier: "Spent") -> "Spent":
        """The difference from an earlier moment."""
        return Spent(*(mine - vars(earlier)[name] for name, mine in vars(self).items()))

    @property
    def processor(self) -> float:
        """Seconds of the service and of its database, which work alternately."""
        return self.service + self.database


class Bench:
    """A dispatcher with `workers` workers on a store."""

    def __init__(self, store: Store, postgres: int | None, workers: int) -> None:
        """`postgres` is the process of the database's server, if there is one."""
        self.time = ProcessorTime(postgres)
        self.pool = PretendedPool(workers, self.time)
        self.dispatcher = Dispatcher(store, self.pool, TIMES, lambda: self.pool.now)
        self.rounds = 0

    def work(self) -> None:
        """Run one round of the dispatcher."""
        self.dispatcher.work_round()
        self.rounds += 1

    def take_in(self, reports: int) -> None:
        """Work until `reports` more reports have been processed."""
        until = self.pool.reports_told + reports
        while self.pool.reports_told < until:
            self.work()

    @property
    def spent(self) -> Spent:
        """The time spent and the work done so far."""
        pool = self.pool
        return Spent(
            passed=pool.now,
            service=self.time.service,
            database=self.time.database,
            wall=time.perf_counter(),
            waited=pool.waited,
            rounds=self.rounds,
            reports=pool.reports_told,
            measurements=pool.measurements_told,
            runs=pool.runs_ended,
        )


def main() -> None:
    """Print every figure of the databases named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("databases", nargs="*", default=DATABASES, metavar="|".join(DATABASES))
    parser.add_argument("--workers", type=int, nargs="+", default=WORKERS)
    asked = parser.parse_args()
    if "sqlite" in asked.databases:
        with tempfile.TemporaryDirectory() as folder:
            url = f"sqlite:///{Path(folder) / 'd3pg.sqlite'}"
            measure_all("SQLite", url, None, asked.workers)
    if "postgresql" in asked.databases:
        with running_postgresql("fsync=on") as server:
            measure_all("PostgreSQL", server.create("d3pg"), server.process_id, asked.workers)


def measure_all(name: str, url: str, postgres: int | None, sizes: Sequence[int]) -> None:
    """Measure one database, initially empty, with increasing numbers of workers."""
    store = Store.open(url)
    submit(store)
    for workers in sizes:
        measure(f"{name}, {workers:,} workers", Bench(store, postgres, workers), workers)
    store.close()


def measure(name: str, bench: Bench, workers: int) -> None:
    """Wait until every worker is in the middle of its work, then measure."""
    bench.work()
    while bench.pool.is_idle:
        bench.work()
    bench.work()  # and has sent a report
    report(f"{name}, until each had its first cohort", bench.pool.now, "s")
    bench.take_in(workers)
    before = bench.spent
    bench.take_in(max(REPORTS, 3 * workers))
    spent = bench.spent.since(before)
    report(f"{name}, reports a round", spent.reports / spent.rounds, "")
    report(f"{name}, processor time a round", 1000 * spent.processor / spent.rounds, "ms")
    report(f"{name}, a report", 1000 * spent.processor / spent.reports, "ms")
    report(f"{name}, a run", 1000 * POINTS * spent.processor / spent.measurements, "ms")
    report(f"{name}, of it the database's sessions", 100 * spent.database / spent.processor, "%")
    report(f"{name}, busy", 100 * spent.processor / spent.passed, "%")
    report(f"{name}, a worker's time lost", 100 * spent.waited / spent.passed / workers, "%")
    report(f"{name}, a worker's longest wait", bench.pool.longest_wait, "s")
    report(f"{name}, saturated at reports", spent.reports / spent.processor, "1/s")
    report(f"{name}, saturated at measurements", spent.measurements / spent.processor, "1/s")
    report(f"{name}, wall time a report, at most", 1000 * spent.wall / spent.reports, "ms")


def submit(store: Store) -> None:
    """Queue all runs in several sweeps, plus those that run during the measurement."""
    cells = QUEUED * 6 // 5 // SWEEPS // COHORT_LIMIT
    specs = [
        RunSpec("ddpg", "Pendulum", seed, Weights(float(cell)))
        for cell in range(cells)
        for seed in range(COHORT_LIMIT)
    ]
    for sweep in range(SWEEPS):
        store.create_sweep(f"sweep {sweep}", 0, {}, specs, environment_versions={"Pendulum": 1})


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.3g} {unit}".rstrip(), flush=True)


if __name__ == "__main__":
    main()
