"""A cohort in training, on a thread of its own.

Its runs are resumed where their checkpoints left them. Runs at the same timestep train together. If
there are several such groups, the most advanced trains first and the others wait for it.

The thread works cycle after cycle and leaves its news in a box; `collect` empties the box. So the
driver hears from the worker every second, even while a kernel compiles, and a worker without a
driver stops by itself: its lease has ended, and another may have its runs.
"""

import threading
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

from algorithms.early_end import Divergence, Failure
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from workers.checkpoints.checkpoint import Checkpoints, Found
from workers.checkpoints.patience import Patience, answered, without_patience
from workers.messages.progress import Activity, CheckpointAttempt, Progress, Resumption
from workers.messages.random_return import RandomReturn
from workers.training.cadence import Cadence

UNCOLLECTED_SECONDS = 12.0
"""A worker whose news was not collected for so long stops before its lease of 15 s has ended."""
NO_ANSWER_SECONDS = 60.0
"""How long a worker retries a place that does not answer, for checkpoints, or to write what was
learned at the end; then it starts again, or reports that it could not write."""
AGAIN_SECONDS = 2.0


class AbandonedError(RuntimeError):
    """A worker's news was not collected for too long, and it stopped."""


@dataclass
class _News:
    """The news since the last `collect`."""

    measurements: list[Measurement] = field(default_factory=list)
    diverged: list[Divergence] = field(default_factory=list)
    failed: list[Failure] = field(default_factory=list)
    finished: list[int] = field(default_factory=list)
    dropped: list[int] = field(default_factory=list)
    resumed: list[Resumption] = field(default_factory=list)
    checkpoints: list[CheckpointAttempt] = field(default_factory=list)
    random_return: RandomReturn | None = None


class CohortThread:
    """Trains the seeds that have `checkpoints` until every one has ended, or `stop`.

    `measure_first`, if given, runs before; its random return is among the first news.
    """

    def __init__(
        self,
        checkpoints: Mapping[int, Checkpoints],
        make_learner: Callable[[Sequence[int]], Learner],
        dropped: Callable[[], Collection[int]],
        on_abandoned: Callable[[], None],
        measure_first: Callable[[], RandomReturn] | None = None,
    ) -> None:
        """Start the thread. `dropped` is called before each cycle; it returns seeds to drop."""
        self._checkpoints = checkpoints
        self._make_learner = make_learner
        self._dropped = dropped
        self._on_abandoned = on_abandoned
        self._measure_first = measure_first
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._is_urgent = threading.Event()  # there is news that is not to wait
        self._stopped = threading.Event()
        self._news = _News()
        self._timestep = 0
        self._training: Sequence[int] = ()
        self._waiting = list(checkpoints)
        self._measured: dict[int, list[Measurement]] = {}
        self._bytes_per_run = 0
        self._activity = Activity.COMPILING
        self._failure: Exception | None = None
        self._collected_at = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="training", daemon=True)
        self._thread.start()

    def collect(self, timeout_seconds: float) -> tuple[Progress, bool]:
        """Wait that long, or until seeds were dropped or all is over; return the news.

        And whether all is over.
        Raises the learner's exception, once its last news has been collected.
        """
        if not self._over.is_set():
            self._is_urgent.wait(timeout_seconds)
            self._is_urgent.clear()
        is_over = self._over.is_set()
        with self._lock:
            self._collected_at = time.monotonic()
            news, self._news = self._news, _News()
            progress = Progress(
                timestep=self._timestep,
                activity=self._activity,
                training=tuple(self._training),
                resumed=tuple(news.resumed),
                checkpoints=tuple(news.checkpoints),
                bytes_per_run=self._bytes_per_run,
                measurements=tuple(news.measurements),
                diverged=tuple(news.diverged),
                failed=tuple(news.failed),
                finished=tuple(news.finished),
                dropped=tuple(news.dropped),
                random_return=news.random_return,
            )
        if is_over and self._failure is not None and news == _News():
            raise self._failure
        return progress, is_over and self._failure is None

    def stop(self) -> None:
        """End after the present cycle, and wait for it."""
        self._stopped.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            found = self._find_checkpoints(self._play_at_random())
            for timestep in sorted({each.timestep for each in found.values()}, reverse=True):
                group = [seed for seed in self._waiting if found[seed].timestep == timestep]
                if group and not self._stopped.is_set():
                    self._train(self._take_up(group, found))
        except AbandonedError as failure:
            self._failure = failure
            self._on_abandoned()
        except Exception as failure:
            self._failure = failure
        finally:
            self._over.set()
            self._is_urgent.set()

    def _play_at_random(self) -> str:
        """Measure the random return if it is requested; return why it could not be measured.

        Runs train without it: their returns are not normalised then.
        """
        if self._measure_first is None:
            return ""
        try:
            measured = self._measure_first()
        except Exception as error:
            return (
                "the task's random return could not be measured, so returns are not normalised: "
                f"{type(error).__name__}: {error}"
            )
        with self._lock:
            self._news.random_return = measured
        return ""

    def _find_checkpoints(self, remark: str) -> dict[int, Found]:
        """Find where each run was left, and report it, with a remark on all of them."""
        patience = self._patience()
        found = {seed: each.find(patience) for seed, each in self._checkpoints.items()}
        self._measured = {seed: [*each.measurements] for seed, each in found.items()}
        with self._lock:
            self._news.measurements.extend(m for each in found.values() for m in each.measurements)
            self._news.resumed.extend(
                Resumption(
                    seed,
                    each.timestep,
                    tuple(each.mixed_with),
                    "; ".join(filter(None, [each.note, remark])),
                )
                for seed, each in found.items()
            )
        return found

    def _take_up(self, seeds: Sequence[int], found: Mapping[int, Found]) -> Learner:
        """Make the learner of seeds that were left at one timestep."""
        learner = self._make_learner(seeds)
        saved = {seed: left for seed in seeds if (left := found[seed].saved) is not None}
        if saved:
            learner.restore(saved)
        with self._lock:
            self._waiting = [seed for seed in self._waiting if seed not in seeds]
            self._timestep, self._training = learner.timestep, seeds
            self._bytes_per_run = learner.bytes_per_run
        return learner

    def _train(self, learner: Learner) -> None:
        if learner.finished:  # the worker that came to their end was lost before it said so
            self._end_again(learner)
        cadence = Cadence()
        while not learner.finished and not self._stopped.is_set():
            if self._is_abandoned():
                raise AbandonedError(f"the news was not collected for {UNCOLLECTED_SECONDS} s")
            self._drop(learner)
            self._cycle(learner)
            if cadence.is_due and not learner.finished:
                begun = time.perf_counter()
                self._save(learner)
                cadence.took(time.perf_counter() - begun)

    def _save(self, learner: Learner) -> None:
        """Write a checkpoint of every run in training. If that fails, training goes on."""
        self._at_once(partial(self._save_run, learner), learner.seeds)

    def _at_once(self, write: Callable[[int], None], seeds: Sequence[int]) -> None:
        """Write for many seeds: the disk takes as long for many threads as for one."""
        if seeds:
            with ThreadPoolExecutor(len(seeds)) as threads:
                list(threads.map(write, seeds))

    def _save_run(self, learner: Learner, seed: int) -> None:
        """Write a run's checkpoint and what it has learned, and report it."""
        problem = ""
        try:
            self._checkpoints[seed].save(learner, self._measured[seed])
        except OSError as error:
            step = learner.timestep
            problem = f"its checkpoint of step {step} could not be written: {error.strerror}"
        with self._lock:
            self._news.checkpoints.append(CheckpointAttempt(seed, learner.timestep, problem))
        self._save_policy(learner, seed)

    def _save_end(self, learner: Learner, seed: int, patience: Patience) -> None:
        """Write what has been learned by the end and, for a longer run, where it ended.

        If the latter fails, a longer run is resumed earlier, or starts again.
        """
        with suppress(OSError):
            if self._checkpoints[seed].save_end(learner, self._measured[seed]):
                with self._lock:
                    self._news.checkpoints.append(CheckpointAttempt(seed, learner.timestep, ""))
        self._save_policy(learner, seed, patience)

    def _end_again(self, learner: Learner) -> None:
        """Report the end of runs whose last checkpoint is that of their end."""
        seeds = list(learner.seeds)
        self._at_once(partial(self._save_policy, learner, patience=self._patience()), seeds)
        with self._lock:
            self._news.finished.extend(seeds)

    def _save_policy(
        self, learner: Learner, seed: int, patience: Patience = without_patience
    ) -> None:
        self._try_to_write(seed, learner, self._checkpoints[seed].save_policy, patience)

    def _try_to_write(
        self,
        seed: int,
        learner: Learner,
        write: Callable[[Learner], None],
        patience: Patience = without_patience,
    ) -> None:
        """Write what a run has learned, or report why not."""
        try:
            answered(partial(write, learner), patience)
        except OSError as error:
            problem = f"what it has learned could not be written: {error.strerror}"
            with self._lock:
                attempt = CheckpointAttempt(seed, learner.timestep, problem)
                self._news.checkpoints.append(attempt)

    def _patience(self) -> Patience:
        """As much as there is, from now on."""
        given_up_at = time.monotonic() + NO_ANSWER_SECONDS
        return lambda: not self._stopped.wait(AGAIN_SECONDS) and time.monotonic() < given_up_at

    def _is_abandoned(self) -> bool:
        with self._lock:
            return time.monotonic() - self._collected_at > UNCOLLECTED_SECONDS

    def _drop(self, learner: Learner) -> None:
        leaving = sorted(set(self._dropped()) & {*learner.seeds, *self._waiting})
        if leaving:
            learner.drop(leaving)
            with self._lock:
                self._waiting = [seed for seed in self._waiting if seed not in leaving]
                self._news.dropped.extend(leaving)
            self._is_urgent.set()

    def _cycle(self, learner: Learner) -> None:
        """One cycle of every seed; seeds that end in it are grouped by how they end."""
        if not learner.seeds:
            return
        before = list(learner.seeds)
        said = learner.advance()
        diverged = [entry for entry in said if isinstance(entry, Divergence)]
        failed = [entry for entry in said if isinstance(entry, Failure)]
        measured = [entry for entry in said if isinstance(entry, Measurement)]
        gone = {entry.seed for entry in said if not isinstance(entry, Measurement)}
        remaining = set() if learner.finished else set(learner.seeds)
        finished = [seed for seed in before if seed not in remaining and seed not in gone]
        for entry in measured:
            self._measured[entry.seed].append(entry)
        for seed in [*remaining, *finished]:
            self._try_to_write(seed, learner, self._checkpoints[seed].save_epoch)
        self._at_once(partial(self._save_end, learner, patience=self._patience()), finished)
        with self._lock:
            self._news.measurements.extend(measured)
            self._news.diverged.extend(diverged)
            self._news.failed.extend(failed)
            self._news.finished.extend(finished)
            self._timestep = learner.timestep
            self._activity = Activity.TRAINING
