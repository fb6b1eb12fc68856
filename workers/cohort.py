"""A cohort in training, on a thread of its own.

The thread works cycle after cycle and leaves its news in a box; `collect` empties the box. So the
one who listens hears from the worker every second even while a kernel compiles, and a worker that
nobody listens to any more stops by itself: its lease has ended, and another may have its runs.
"""

import threading
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from algorithms.learner import Learner
from algorithms.measurement import Divergence, Measurement
from workers.progress import Activity, Progress
from workers.random_return import RandomReturn

PATIENCE_SECONDS = 30.0
"""A worker whose news nobody collected for so long has lost its lease."""


class AbandonedError(RuntimeError):
    """Nobody collected a worker's news for too long, and it stopped."""


@dataclass
class _News:
    """What has happened since the last `collect`."""

    measurements: list[Measurement] = field(default_factory=list)
    diverged: list[Divergence] = field(default_factory=list)
    finished: list[int] = field(default_factory=list)
    dropped: list[int] = field(default_factory=list)
    random_return: RandomReturn | None = None


class Cohort:
    """Trains what `make_learner` makes until every seed has ended, or `stop`.

    `measure_first`, where given, runs before; its random return is among the first news.
    """

    def __init__(
        self,
        make_learner: Callable[[], Learner],
        dropped: Callable[[], Collection[int]],
        on_abandoned: Callable[[], None],
        measure_first: Callable[[], RandomReturn] | None = None,
    ) -> None:
        """Start the thread. `dropped` is asked before each cycle which seeds are to leave."""
        self._make_learner = make_learner
        self._dropped = dropped
        self._on_abandoned = on_abandoned
        self._measure_first = measure_first
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._stopped = threading.Event()
        self._news = _News()
        self._timestep = 0
        self._activity = Activity.COMPILING
        self._failure: Exception | None = None
        self._collected_at = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="training", daemon=True)
        self._thread.start()

    def collect(self, timeout_seconds: float) -> tuple[Progress, bool]:
        """Wait that long, or until all is over; return the news and whether all is over.

        Raises what the learner raised, once its last news have been collected.
        """
        self._over.wait(timeout_seconds)
        is_over = self._over.is_set()
        with self._lock:
            self._collected_at = time.monotonic()
            news, self._news = self._news, _News()
            progress = Progress(
                timestep=self._timestep,
                activity=self._activity,
                measurements=tuple(news.measurements),
                diverged=tuple(news.diverged),
                finished=tuple(news.finished),
                dropped=tuple(news.dropped),
                random_return=news.random_return,
            )
        if is_over and self._failure is not None and news == _News():
            raise self._failure
        return progress, is_over and self._failure is None

    def stop(self) -> None:
        """End after the cycle that is under way, and wait for it."""
        self._stopped.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            if self._measure_first is not None:
                measured = self._measure_first()
                with self._lock:
                    self._news.random_return = measured
            learner = self._make_learner()
            while not learner.finished and not self._stopped.is_set():
                if self._is_abandoned():
                    raise AbandonedError(f"nobody collected the news for {PATIENCE_SECONDS} s")
                self._drop(learner)
                self._cycle(learner)
        except AbandonedError as failure:
            self._failure = failure
            self._on_abandoned()
        except Exception as failure:
            self._failure = failure
        finally:
            self._over.set()

    def _is_abandoned(self) -> bool:
        with self._lock:
            return time.monotonic() - self._collected_at > PATIENCE_SECONDS

    def _drop(self, learner: Learner) -> None:
        leaving = sorted(set(self._dropped()) & set(learner.seeds))
        if leaving:
            learner.drop(leaving)
            with self._lock:
                self._news.dropped.extend(leaving)

    def _cycle(self, learner: Learner) -> None:
        """One cycle of every seed; those that end in it are told apart by how."""
        if not learner.seeds:
            return
        before = list(learner.seeds)
        said = learner.advance()
        diverged = [entry for entry in said if isinstance(entry, Divergence)]
        gone = {entry.seed for entry in diverged}
        remaining = set() if learner.finished else set(learner.seeds)
        with self._lock:
            self._news.measurements.extend(e for e in said if isinstance(e, Measurement))
            self._news.diverged.extend(diverged)
            self._news.finished.extend(
                seed for seed in before if seed not in remaining and seed not in gone
            )
            self._timestep = learner.timestep
            self._activity = Activity.TRAINING
