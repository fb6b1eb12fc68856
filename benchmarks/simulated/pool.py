"""A Pool of many simulated workers, with a simulated clock.

The clock counts the processor time of the service that serves the workers; time in which it has
nothing to do is skipped. So one thread can simulate a thousand workers, which wait only for the
service's work, not for the machine's other work.
"""

import heapq
import json
import random
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from algorithms.measurement import MEASURE_EVERY, Measurement
from benchmarks.simulated.processor_time import ProcessorTime
from workers.messages.progress import Activity, Progress, Resumption
from workers.messages.random_return import RandomReturn
from workers.messages.report import Busy, Ended, News, Ready, Report, from_line, to_line
from workers.messages.work import Work

POINTS = 50
"""Measurements of a run, one per second."""
UNTAKEN = 2
"""Reports of a worker that may wait to be processed; beyond that, the worker waits."""
DIAGNOSTICS = ("critic_loss", "actor_loss", "action_gradient_cosine", "state_gradient_cosine",
               "mean_q", "update_seconds")  # fmt: skip


@dataclass
class PretendedWorker:
    """One worker, its work, and how many measurements of each seed it has reported."""

    name: str
    told: int = 0
    began: float = 0.0
    work: Work = field(default_factory=lambda: Work("", ()))

    def begin(self, work: Work, now: float, told: int = 0) -> list[Report]:
        """Begin a cohort, after the first `told` measurements of each seed."""
        self.work, self.told, self.began = work, told, now - told
        first = Progress(0, Activity.COMPILING)
        return [Busy(self.name, work), News(self.name, work.cohort, first)]

    def due_after(self, now: float) -> float:
        """The time of the next report."""
        return min(now + self.work.report_seconds, self.began + POINTS)

    def report(self, now: float) -> list[Report]:
        """Report the measurements up to now."""
        is_first, before = not self.told, self.told
        self.told = min(round(now - self.began), POINTS)
        seeds = tuple(spec.seed for spec in self.work.specs)
        is_over = self.told == POINTS
        progress = Progress(
            MEASURE_EVERY * self.told,
            measurements=tuple(
                measured(seed, MEASURE_EVERY * (place + 1))
                for place in range(before, self.told)
                for seed in seeds
            ),
            finished=seeds if is_over else (),
            resumed=tuple(Resumption(seed, 0) for seed in seeds) if is_first else (),
            bytes_per_run=5_000_000,
            fingerprint={"cpu": "pretended", "numpy": "2"} if is_first else {},
            random_return=self._random_return() if is_first else None,
        )
        news = News(self.name, self.work.cohort, progress)
        return [news, Ended(self.name, self.work.cohort)] if is_over else [news]

    def _random_return(self) -> RandomReturn | None:
        environment = self.work.specs[0].environment
        is_asked = self.work.measure_random_return
        return RandomReturn(environment, 1, -1.0, -2.0, 0.0, 1000) if is_asked else None


def measured(seed: int, timestep: int) -> Measurement:
    """A measurement of the usual length."""
    value = -1000.0 / (timestep + seed)
    named = {name: value / place for place, name in enumerate(DIAGNOSTICS, 1)}
    return Measurement(
        seed, timestep, value, value / 3, timestep // 2, 3 * timestep, timestep / 7e3, named, 0.25
    )


class PretendedPool:
    """A pool of `size` workers. `now` is its time, in seconds, of the last call of `reports`.

    reports_told       reports with measurements so far
    measurements_told  measurements in them
    runs_ended         runs trained to their end
    """

    def __init__(self, size: int, spent: ProcessorTime) -> None:
        """`spent` is the time that passes in the pool."""
        self.now = 0.0
        self.reports_told = self.measurements_told = self.runs_ended = 0
        self.longest_wait = 0.0
        self._size = size
        self._spent = spent
        self._skipped = 0.0
        self._waited = 0.0
        self._draw = random.Random(0)  # noqa: S311
        self._workers: dict[str, PretendedWorker] = {}
        self._idle_since: dict[str, float] = {}
        self._due: list[tuple[float, str]] = []
        self._lines: list[str] = []

    def start(self) -> None:
        """Start all workers at once."""
        for number in range(self._size):
            worker = PretendedWorker(f"worker-{number}", -1)
            self._workers[worker.name] = worker
            self._idle_since[worker.name] = self._time()
            self._say([Ready(worker.name, number, "here")])

    def train(self, worker: str, work: Work) -> None:
        """Give a worker a cohort; its first one is partly done, so that not all end at once."""
        json.dumps(work.to_json())  # as for a real pool
        with self._spent.uncounted():
            now, trainee = self._time(), self._workers[worker]
            self._wait(now - self._idle_since.pop(worker))
            told = self._draw.randrange(POINTS) if trainee.told < 0 else 0
            self._say(trainee.begin(work, now, told))
            heapq.heappush(self._due, (trainee.due_after(now), worker))

    def demand(self, workers: int) -> None:
        """Do nothing: the number of workers is fixed."""

    def reports(self, timeout_seconds: float, gather_seconds: float = 0.0) -> list[Report]:
        """Return the workers' reports by now; skip time until there is one."""
        with self._spent.uncounted():
            self.now = self._time()
            if not self._lines and self._due:
                self._skip_to(min(self._due[0][0], self.now + timeout_seconds))
            if self._lines or (self._due and self._due[0][0] <= self.now):
                self._skip_to(self.now + gather_seconds)
            self._train_until(self.now)
            lines, self._lines = self._lines, []
        return [from_line(line) for line in lines]

    def acknowledge(self, count: int) -> None:
        """Do nothing: no reports are kept."""

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        """Raise an error: nothing is cancelled."""
        raise AssertionError(f"{worker} was told to drop {seeds}")

    def kill(self, worker: str) -> None:
        """Raise an error: no worker is silent."""
        raise AssertionError(f"{worker} was to be killed")

    def close(self) -> None:
        """Do nothing."""

    @property
    def is_idle(self) -> bool:
        """Whether any worker has no cohort."""
        return bool(self._idle_since)

    @property
    def waited(self) -> float:
        """Seconds that all workers have waited for a cohort or for reports to be processed."""
        return self._waited + sum(self.now - since for since in self._idle_since.values())

    def _time(self) -> float:
        return self._spent.total + self._skipped

    def _skip_to(self, until: float) -> None:
        self._skipped += max(until - self.now, 0.0)
        self.now = max(until, self.now)

    def _train_until(self, now: float) -> None:
        """Let every worker send its reports up to `now`, unless it has to wait."""
        said: dict[str, int] = {}
        held_up: list[str] = []
        while self._due and self._due[0][0] <= now:
            due, name = heapq.heappop(self._due)
            said[name] = said.get(name, 0) + 1
            if said[name] > UNTAKEN:
                self._wait(now - due)
                self._workers[name].began += now - due
                held_up.append(name)
            else:
                self._report(self._workers[name], due)
        for name in held_up:
            heapq.heappush(self._due, (now, name))

    def _report(self, worker: PretendedWorker, due: float) -> None:
        before = worker.told
        self._say(worker.report(due))
        self.reports_told += 1
        self.measurements_told += (worker.told - before) * len(worker.work.runs)
        if worker.told < POINTS:
            heapq.heappush(self._due, (worker.due_after(due), worker.name))
        else:
            self.runs_ended += len(worker.work.runs)
            self._idle_since[worker.name] = due

    def _wait(self, seconds: float) -> None:
        self._waited += seconds
        self.longest_wait = max(self.longest_wait, seconds)

    def _say(self, reports: Sequence[Report]) -> None:
        self._lines += map(to_line, reports)
