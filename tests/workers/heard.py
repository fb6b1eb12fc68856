"""A pool on a real Ray, and all that it says."""

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from workers.messages.assignment import Assignment
from workers.messages.report import News, Ready, Report
from workers.messages.run_spec import RunSpec
from workers.messages.work import Work
from workers.pool.pool import PoolUnavailableError
from workers.pool.process import PoolProcess, PoolSettings

ENDLESS = [RunSpec("ddpg", "Pendulum", seed, timesteps=10**8) for seed in range(2)]
PATIENCE_SECONDS = 240.0  # kernels may have to be compiled first


def assigned(specs: list[RunSpec]) -> list[Assignment]:
    return [Assignment(f"run-{spec.seed}", 1, spec, 1) for spec in specs]


class Heard:
    """A pool with all that it has reported."""

    def __init__(self, folder: Path, ray_address: str = "", worker_bytes: int = 0) -> None:
        self.settings = PoolSettings(
            2, ray_address, folder, folder / "checkpoints", worker_bytes=worker_bytes
        )
        self.pool = PoolProcess(self.settings)
        self.reports: list[Report] = []
        self.listened = 0
        """How many of the reports somebody has waited for; the others are looked at first."""
        self.cohorts = 0

    def start_pool(self) -> None:
        """Start the pool, once its cluster can be joined."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not self.reports:
            assert time.monotonic() < deadline, "the pool did not start"
            self.pool.start()
            with suppress(PoolUnavailableError):
                self.wait_for(lambda _: True)

    def wait_until(self, is_so: Callable[[list[Report]], bool]) -> None:
        """Listen until that is so of all that was reported."""
        while not is_so(self.reports):
            self.wait_for(lambda _: True)

    def wait_for(self, is_it: Callable[[Report], bool]) -> Report:
        """Listen until a report comes that is the one."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while time.monotonic() < deadline:
            while self.listened < len(self.reports):
                report = self.reports[self.listened]
                self.listened += 1
                if is_it(report):
                    return report
            self.reports += self.pool.reports(1.0)
        raise AssertionError(f"not heard; the last: {self.reports[-3:]}")

    def idle_worker(self) -> Ready:
        """Another worker, once one is ready."""
        ready = self.wait_for(lambda report: isinstance(report, Ready))
        assert isinstance(ready, Ready)
        return ready

    def train(self, worker: str, specs: list[RunSpec], *, measure: bool = False) -> str:
        """Have specs trained; the cohort's name."""
        self.cohorts += 1
        cohort = f"cohort-{self.cohorts}"
        self.work = Work(cohort, tuple(assigned(specs)), measure_random_return=measure)
        self.pool.train(worker, self.work)
        return cohort

    def wait_for_training(self, worker: str) -> None:
        def is_training(report: Report) -> bool:
            return (
                isinstance(report, News)
                and report.worker == worker
                and report.progress.timestep > 0
            )

        self.wait_for(is_training)
