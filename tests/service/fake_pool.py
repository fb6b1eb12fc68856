"""A pool of pretended workers without threads or clocks: each round every worker does one cycle.

A run's measurements follow from its seed and timestep alone, as a real run's do. Tests make workers
crash, freeze, disobey and raise; what the dispatcher then does shows in the store.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from algorithms.measurement import Divergence, Measurement
from workers.pool import PoolUnavailableError
from workers.progress import Progress
from workers.random_return import RandomReturn
from workers.report import Ended, Failed, Lost, News, Ready, Report
from workers.run_spec import RunSpec

CYCLE = 800


def measurement_of(seed: int, timestep: int) -> Measurement:
    """What a run measures there, whoever trains it."""
    value = -1000.0 / timestep - seed
    return Measurement(seed, timestep, value, value / 2, timestep // 2, 0, 0.1, {"loss": value})


@dataclass
class FakeWorker:
    """One worker and what it is training."""

    name: str
    specs: Sequence[RunSpec] = ()
    seeds: list[int] = field(default_factory=list)
    timestep: int = 0
    to_drop: set[int] = field(default_factory=set)
    random_return: RandomReturn | None = None
    is_frozen: bool = False
    is_deaf: bool = False  # does not drop what it is told to


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

    def train(self, worker: str, specs: Sequence[RunSpec], *, measure_random_return: bool) -> None:
        if (found := self.workers.get(worker)) is None:
            return
        found.specs, found.seeds, found.timestep = specs, [spec.seed for spec in specs], 0
        found.to_drop, found.is_frozen = set(), self.is_freezing
        if measure_random_return:
            task = specs[0].environment
            self.asked_random_returns.append(task)
            found.random_return = RandomReturn(task, 1, -1.0, -2.0, 0.0, 1000)

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        if (found := self.workers.get(worker)) is not None and not found.is_deaf:
            found.to_drop |= set(seeds)

    def kill(self, worker: str) -> None:
        self.crash(worker, "it was killed")

    def crash(self, worker: str, reason: str = "its worker was lost: SIGKILL") -> None:
        if self.workers.pop(worker, None) is not None:
            self._reports.append(Lost(worker, reason, "last words"))
            self._make()

    def reports(self, timeout_seconds: float) -> list[Report]:
        del timeout_seconds
        if self.problem:
            raise PoolUnavailableError(self.problem)
        for worker in list(self.workers.values()):
            if worker.specs and not worker.is_frozen:
                self._cycle(worker)
        found, self._reports = self._reports, []
        return found

    def close(self) -> None:
        self.is_closed = True
        self.workers.clear()

    def _make(self) -> None:
        self._made += 1
        name = f"worker-{self._made}"
        self.workers[name] = FakeWorker(name)
        self._reports.append(Ready(name, 1000 + self._made, "here"))

    def _cycle(self, worker: FakeWorker) -> None:
        dropped = tuple(seed for seed in worker.seeds if seed in worker.to_drop)
        worker.seeds = [seed for seed in worker.seeds if seed not in dropped]
        worker.timestep += CYCLE
        if worker.timestep == 2 * CYCLE and self.raising & set(worker.seeds):
            self._reports.append(Failed(worker.name, "Traceback\nValueError: x", "output"))
            worker.specs = ()
            return
        diverged: tuple[int, ...] = ()
        if worker.timestep == 2 * CYCLE:
            diverged = tuple(seed for seed in worker.seeds if seed in self.diverging)
            worker.seeds = [seed for seed in worker.seeds if seed not in diverged]
        is_over = worker.timestep >= worker.specs[0].timesteps
        progress = Progress(
            timestep=worker.timestep,
            measurements=tuple(measurement_of(seed, worker.timestep) for seed in worker.seeds),
            diverged=tuple(Divergence(s, worker.timestep, 7, "critic loss") for s in diverged),
            finished=tuple(worker.seeds) if is_over else (),
            dropped=dropped,
            fingerprint={"cpu": "a"} if worker.timestep == CYCLE else {},
            random_return=worker.random_return,
        )
        worker.random_return = None
        self._reports.append(News(worker.name, progress))
        if is_over or not worker.seeds:
            self._reports.append(Ended(worker.name))
            worker.specs = ()
