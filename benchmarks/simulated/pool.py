"""A Pool of many pretended workers, in a time of their own.

That time is the processor time of those who serve the workers, and the time in which these have
nothing to do is skipped. So a thousand workers are pretended by one thread, and what they wait for
is the work of the service, not the machine's other work.
"""

import heapq
import json
import random
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from algorithms.measurement import MEASURE_EVERY, Measurement
from benchmarks.simulated.processor_time import ProcessorTime
from workers.progress import Activity, Progress, Resumption
from workers.random_return import RandomReturn
from workers.report import Busy, Ended, News, Ready, Report, from_line, to_line
from workers.work import Work

POINTS = 50
"""Measurements of a run, one a report."""
REPORT_SECONDS = 1.0
UNTAKEN = 2
"""Reports of a worker that may wait to be taken in; then the worker waits."""
DIAGNOSTICS = ("critic_loss", "actor_loss", "action_gradient_cosine", "state_gradient_cosine",
               "mean_q", "update_seconds")  # fmt: skip


@dataclass
class PretendedWorker:
    """One worker, and how many measurements of each seed it has told.

    Its first cohort is taken up in its midst, so that not all end at once.
    """

    name: str
    point: int
    cohort: str = ""
    seeds: Sequence[int] = ()
    measures: str = ""

    def begin(self, work: Work) -> list[Report]:
        """Take a cohort up."""
        self.cohort, self.seeds = work.cohort, [spec.seed for spec in work.specs]
        self.measures = work.specs[0].environment if work.measure_random_return else ""
        first = Progress(0, Activity.COMPILING)
        return [Busy(self.name, self.cohort, work.note), News(self.name, self.cohort, first)]

    def report(self) -> list[Report]:
        """Measure every seed once more."""
        is_first, self.point = self.seeds and not self.point, self.point + 1
        is_over = self.point == POINTS
        timestep = MEASURE_EVERY * self.point
        measured = self.measures and RandomReturn(self.measures, 1, -1.0, -2.0, 0.0, 1000)
        progress = Progress(
            timestep,
            measurements=tuple(point(seed, timestep) for seed in self.seeds),
            finished=tuple(self.seeds) if is_over else (),
            resumed=tuple(Resumption(seed, 0) for seed in self.seeds) if is_first else (),
            bytes_per_run=5_000_000,
            fingerprint={"cpu": "pretended", "numpy": "2"} if is_first else {},
            random_return=measured or None,
        )
        self.measures = ""
        news = News(self.name, self.cohort, progress)
        return [news, Ended(self.name, self.cohort)] if is_over else [news]


def point(seed: int, timestep: int) -> Measurement:
    value = -1000.0 / (timestep + seed)
    named = {name: value / place for place, name in enumerate(DIAGNOSTICS, 1)}
    return Measurement(
        seed, timestep, value, value / 3, timestep // 2, 3 * timestep, timestep / 7e3, named
    )


@dataclass
class PretendedPool:
    """`size` workers; `spent` is what counts as time that passes.

    now       the pool's time, in seconds, when reports were last asked for
    taken     how many reports with measurements were taken in
    ended     how many runs were trained to their end
    lost      seconds that workers have waited: for a cohort, or for their news to be taken in
    longest   of these waits
    """

    size: int
    spent: ProcessorTime
    now: float = 0.0
    taken: int = 0
    ended: int = 0
    lost: float = 0.0
    longest: float = 0.0
    acknowledged: int = 0
    _skipped: float = 0.0
    _workers: dict[str, PretendedWorker] = field(default_factory=dict)
    _idle_since: dict[str, float] = field(default_factory=dict)
    _due: list[tuple[float, str]] = field(default_factory=list)
    _lines: list[str] = field(default_factory=list)

    def start(self) -> None:
        draw = random.Random(0)  # noqa: S311
        for number in range(self.size):
            name = f"worker-{number}"
            self._workers[name] = PretendedWorker(name, draw.randrange(POINTS))
            self._say([Ready(name, number, "here")])
            self._idle_since[name] = self._time()

    def train(self, worker: str, work: Work) -> None:
        json.dumps(work.to_json())  # as it goes to a real pool
        with self.spent.uncounted():
            now, trainee = self._time(), self._workers[worker]
            self._wait(now - self._idle_since.pop(worker))
            self._say(trainee.begin(work))
            heapq.heappush(self._due, (now + REPORT_SECONDS, worker))

    def reports(self, timeout_seconds: float) -> list[Report]:
        with self.spent.uncounted():
            self.now = self._time()
            if not self._lines and self._due:
                until = min(self._due[0][0], self.now + timeout_seconds)
                self._skipped += max(until - self.now, 0.0)
                self.now = max(until, self.now)
            self._train_until(self.now)
            lines, self._lines = self._lines, []
        return [from_line(line) for line in lines]

    def acknowledge(self, count: int) -> None:
        self.acknowledged += count

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        raise AssertionError(f"{worker} was told to drop {seeds}")

    def kill(self, worker: str) -> None:
        raise AssertionError(f"{worker} was to be killed")

    def close(self) -> None:
        pass

    @property
    def idle(self) -> int:
        """How many workers have no cohort."""
        return len(self._idle_since)

    def waiting(self) -> float:
        """Seconds that those workers have waited so far that wait for a cohort now."""
        return sum(self.now - since for since in self._idle_since.values())

    def _time(self) -> float:
        return self.spent.total + self._skipped

    def _train_until(self, now: float) -> None:
        """Have every worker say what it has to say by then, as far as it need not wait."""
        said: dict[str, int] = {}
        held_up: list[str] = []
        while self._due and self._due[0][0] <= now:
            due, name = heapq.heappop(self._due)
            said[name] = said.get(name, 0) + 1
            if said[name] > UNTAKEN:
                self._wait(now - due)
                held_up.append(name)
            else:
                self._report(self._workers[name], due)
        for name in held_up:
            heapq.heappush(self._due, (now, name))

    def _report(self, worker: PretendedWorker, due: float) -> None:
        reports = worker.report()
        self._say(reports)
        self.taken += 1
        if worker.point < POINTS:
            heapq.heappush(self._due, (due + REPORT_SECONDS, worker.name))
        else:
            worker.point = 0
            self.ended += len(worker.seeds)
            self._idle_since[worker.name] = due

    def _wait(self, seconds: float) -> None:
        self.lost += seconds
        self.longest = max(self.longest, seconds)

    def _say(self, reports: Sequence[Report]) -> None:
        self._lines += map(to_line, reports)
