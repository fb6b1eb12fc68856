"""A pool of pretended workers without threads or clocks: each round every worker does one cycle.

A run's measurements follow from its seed and timestep alone, as a real run's do. Tests make workers
crash, freeze, disobey and raise; what the dispatcher then does shows in the store.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from algorithms.early_end import Divergence
from algorithms.measurement import Measurement
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.report import Busy, Ended, Failed, Lost, News, Ready, Report
from workers.messages.run_spec import RunSpec
from workers.messages.work import Work
from workers.pool.pool import PoolUnavailableError

CYCLE = 800


def measurement_of(seed: int, timestep: int) -> Measurement:
    """What a run measures there, whoever trains it."""
    value = -1000.0 / timestep - seed
    return Measurement(
        seed, timestep, value, value / 2, timestep // 2, 0, 0.1, {"loss": value}, 0.05
    )


@dataclass
class FakeWorker:
    """One worker and what it is training."""

    name: str
    cohort: str = ""
    specs: Sequence[RunSpec] = ()
    seeds: list[int] = field(default_factory=list)
    timestep: int = 0
    to_drop: set[int] = field(default_factory=set)
    random_return: RandomReturn | None = None
    is_frozen: bool = False
    is_deaf: bool = False  # does not drop what it is told to

    def begin(self, work: Work) -> Report:
        """Train a cohort from the start."""
        self.cohort, self.specs = work.cohort, work.specs
        self.seeds, self.timestep = [spec.seed for spec in self.specs], 0
        self.to_drop = set()
        if work.measure_random_return:
            self.random_return = RandomReturn(self.specs[0].environment, 1, -1.0, -2.0, 0.0, 1000)
        return Busy(self.name, work)

    def drop(self, seeds: Collection[int]) -> None:
        """Train these seeds no further."""
        if not self.is_deaf:
            self.to_drop |= set(seeds)

    def cycle(self, diverging: Collection[int], raising: Collection[int]) -> list[Report]:
        """Train one cycle; `diverging` seeds diverge and `raising` ones raise in the second."""
        dropped = tuple(seed for seed in self.seeds if seed in self.to_drop)
        self.seeds = [seed for seed in self.seeds if seed not in dropped]
        self.timestep += CYCLE
        diverged: tuple[int, ...] = ()
        if self.timestep == 2 * CYCLE:
            if set(raising) & set(self.seeds):
                self.specs = ()
                return [Failed(self.name, self.cohort, "Traceback\nValueError: x", "output")]
            diverged = tuple(seed for seed in self.seeds if seed in diverging)
            self.seeds = [seed for seed in self.seeds if seed not in diverged]
        is_over = self.timestep >= self.specs[0].timesteps
        progress = Progress(
            timestep=self.timestep,
            measurements=tuple(measurement_of(seed, self.timestep) for seed in self.seeds),
            diverged=tuple(Divergence(s, self.timestep, 7, "critic loss") for s in diverged),
            finished=tuple(self.seeds) if is_over else (),
            dropped=dropped,
            fingerprint={"cpu": "a"} if self.timestep == CYCLE else {},
            random_return=self.random_return,
        )
        self.random_return = None
        if not is_over and self.seeds:
            return [News(self.name, self.cohort, progress)]
        self.specs = ()
        return [News(self.name, self.cohort, progress), Ended(self.name, self.cohort)]


class FakePool:
    """A Pool of `size` workers. `diverging` seeds diverge and `raising` ones raise at 1600."""

    def __init__(self, size: int = 2) -> None:
        self.size = size
        self.workers: dict[str, FakeWorker] = {}
        self.diverging: set[int] = set()
        self.raising: set[int] = set()
        self.is_freezing = False  # a worker freezes as it is given work
        self.problem = ""
        self.starts = 0
        self.acknowledged = 0
        self.demanded: list[int] = []
        self.gathered: list[float] = []
        self.asked_random_returns: list[str] = []
        self.is_closed = False
        self._made = 0
        self._reports: list[Report] = []

    def start(self) -> None:
        self.starts += 1
        if self.problem:
            raise PoolUnavailableError(self.problem)
        self.workers.clear()
        self._reports.clear()
        for _ in range(self.size):
            self._make()

    def train(self, worker: str, work: Work) -> None:
        if (found := self.workers.get(worker)) is None:
            return
        self._reports.append(found.begin(work))
        found.is_frozen = self.is_freezing
        if work.measure_random_return:
            self.asked_random_returns.append(work.specs[0].environment)

    def demand(self, workers: int) -> None:
        self.demanded.append(workers)

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        if (found := self.workers.get(worker)) is not None:
            found.drop(seeds)

    def kill(self, worker: str) -> None:
        self.crash(worker, "it was killed")

    def crash(self, worker: str, reason: str = "its worker was lost: SIGKILL") -> None:
        if self.workers.pop(worker, None) is not None:
            self._reports.append(Lost(worker, reason, "last words"))
            self._make()

    def reports(self, timeout_seconds: float, gather_seconds: float = 0.0) -> list[Report]:
        del timeout_seconds
        self.gathered.append(gather_seconds)
        if self.problem:
            raise PoolUnavailableError(self.problem)
        for worker in list(self.workers.values()):
            if worker.specs and not worker.is_frozen:
                self._reports += worker.cycle(self.diverging, self.raising)
        found, self._reports = self._reports, []
        return found

    def acknowledge(self, count: int) -> None:
        self.acknowledged += count

    def close(self) -> None:
        self.is_closed = True
        self.workers.clear()

    def _make(self) -> None:
        self._made += 1
        name = f"worker-{self._made}"
        self.workers[name] = FakeWorker(name)
        self._reports.append(Ready(name, 1000 + self._made, "here"))
