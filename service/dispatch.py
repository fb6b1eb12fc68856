"""Dispatch: between the queue in the store and the workers of a pool.

One thread repeats a round: take the pool's reports to the store, carry out what was cancelled,
give up workers that fell silent, put expired leases back into the queue, hand out work to the
idle. The store is the record; what is kept here can be lost at any time, and then every lease
runs out and every run is claimed again.

A report leaves the inbox when the store has it. While the database refuses (a full disk) reports
wait, and go in once it takes them again.
"""

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import structlog

from service.claim import Claim
from service.store.store import Store
from workers.pool import Pool, PoolUnavailableError
from workers.report import Ended, Failed, Lost, News, Ready, Report
from workers.run_spec import COHORT_LIMIT

log = structlog.get_logger(__name__)


@dataclass(frozen=True)
class DispatchTimes:
    """All in seconds.

    lease    a worker that is not heard of for so long has lost its runs
    grace    a worker that was told to drop a run has so long to do so before it is killed
    round    longest wait for reports; how late a cancelling or a new sweep is seen
    expiry   between two looks for expired leases
    restart  before a pool that failed is started again, doubled each time up to `longest_restart`
    """

    lease: float = 15.0
    grace: float = 5.0
    round: float = 0.1
    expiry: float = 1.0
    restart: float = 1.0
    longest_restart: float = 30.0


@dataclass
class _Cohort:
    """What a worker is training, and the task whose random return it was asked to measure.

    `told` says since when each run has been dropped.
    """

    claim: Claim
    heard_at: float
    measures: tuple[str, int] | None
    told: dict[str, float] = field(default_factory=dict)


class Dispatcher:
    """Hands out runs and takes in what comes of them. `start` begins, `stop` ends in order."""

    def __init__(
        self,
        store: Store,
        pool: Pool,
        times: DispatchTimes | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Begin nothing yet; the clock is for tests."""
        self._store = store
        self._pool = pool
        self._times = times or DispatchTimes()
        self._clock = clock
        self._inbox: deque[Report] = deque()
        self._idle: dict[str, None] = {}  # in the order they became so
        self._cohorts: dict[str, _Cohort] = {}
        self._pool_is_up = False
        self._pool_problem = "the cluster is starting"
        self._store_problem = ""
        self._restart_at = 0.0
        self._pause = self._times.restart
        self._expiry_at = 0.0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="dispatch", daemon=True)

    def start(self) -> None:
        """Start the thread; it starts the pool."""
        self._thread.start()

    def stop(self) -> None:
        """Queue again what is in training, end the pool and the thread."""
        self._stopping.set()
        self._thread.join()

    @property
    def problem(self) -> str | None:
        """Why no run can start now, as a sentence; None while they can."""
        return self._store_problem or self._pool_problem or None

    @property
    def workers(self) -> dict[str, bool]:
        """The workers that are up, and whether each is busy."""
        idle, busy = list(self._idle), list(self._cohorts)  # whole, whatever the thread does
        return {**dict.fromkeys(idle, False), **dict.fromkeys(busy, True)}

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self.work_round()
                self._store_problem = ""
            except Exception as error:  # a full disk, a database that restarts: tried again
                if not self._store_problem:
                    log.exception("dispatch is held up")
                self._store_problem = f"the database refuses: {error}"
                self._stopping.wait(1.0)
        self._close()

    def _close(self) -> None:
        for cohort in self._cohorts.values():
            try:
                self._store.release(cohort.claim, "the service was stopped")
            except Exception:  # its lease runs out by itself
                log.exception("a claim could not be released")
        self._pool.close()

    def work_round(self) -> None:
        """Do one round. Raises what the store raises; nothing is lost then."""
        self._listen()
        while self._inbox:
            self._take(self._inbox[0])
            self._inbox.popleft()
        self._cancel()
        self._give_up_silent()
        self._requeue_expired()
        self._hand_out()

    # ---- what the pool says

    def _listen(self) -> None:
        try:
            if not self._pool_is_up:
                self._start_pool()
            else:
                # Also while the database refuses what came before: silence must mean silence.
                self._inbox.extend(self._pool.reports(0.0 if self._inbox else self._times.round))
        except PoolUnavailableError as error:
            self._lose_pool(str(error))

    def _start_pool(self) -> None:
        wait = self._restart_at - self._clock()
        if wait > 0:
            self._stopping.wait(min(wait, self._times.round))
            return
        self._pool.start()
        self._pool_is_up = True

    def _lose_pool(self, reason: str) -> None:
        """Every worker is lost with its pool, which is started again after a pause."""
        log.warning("the cluster is unreachable", reason=reason)
        now = time.strftime("%H:%M:%S")
        self._pool_problem = f"the cluster is unreachable since {now}: {reason}"
        self._pool_is_up = False
        self._idle.clear()
        for worker in self._cohorts:
            self._inbox.append(Lost(worker, "its worker was lost with the cluster", ""))
        self._restart_at = self._clock() + self._pause
        self._pause = min(2 * self._pause, self._times.longest_restart)

    def _take(self, report: Report) -> None:
        """Bring one report to the store, then act on it; again after an error does no harm."""
        match report:
            case Ready(worker):
                self._idle[worker] = None
                self._pool_problem = ""
                self._pause = self._times.restart
            case News(worker) if worker in self._cohorts:
                self._take_news(report, self._cohorts[worker])
            case Ended(worker) if worker in self._cohorts:
                self._store.lose(self._cohorts[worker].claim, "its worker ended before it did")
                self._free(worker)
            case Failed(worker, error, log_tail) if worker in self._cohorts:
                self._store.fail(self._cohorts[worker].claim, error, log_tail)
                self._free(worker)
            case Lost(worker, reason, log_tail):
                if worker in self._cohorts:
                    self._store.lose(self._cohorts[worker].claim, reason, log_tail)
                self._cohorts.pop(worker, None)
                self._idle.pop(worker, None)
            case _:  # of a worker that was given up
                pass

    def _take_news(self, news: News, cohort: _Cohort) -> None:
        """Record news; runs that are no longer ours are to be trained no further."""
        cohort.heard_at = self._clock()
        held = self._store.record(cohort.claim, news.progress)
        ended = {
            *news.progress.finished,
            *news.progress.dropped,
            *(divergence.seed for divergence in news.progress.diverged),
        }
        taken_away = {
            run.spec.seed
            for run in cohort.claim.runs
            if run.run_id not in held and run.spec.seed not in ended
        }
        if taken_away:
            self._pool.drop(news.worker, taken_away)
        cohort.claim = cohort.claim.only(held)

    def _free(self, worker: str) -> None:
        del self._cohorts[worker]
        self._idle[worker] = None

    # ---- what the pool is told

    def _cancel(self) -> None:
        """Tell workers to drop cancelled runs; end those that do not within the grace."""
        if not self._cohorts:
            return
        cancelling = self._store.cancelling_runs()
        for worker, cohort in list(self._cohorts.items()):
            runs = [run for run in cohort.claim.runs if run.run_id in cancelling]
            untold = [run for run in runs if run.run_id not in cohort.told]
            if untold:
                self._pool.drop(worker, [run.spec.seed for run in untold])
                cohort.told.update(dict.fromkeys((run.run_id for run in untold), self._clock()))
            if any(self._clock() - cohort.told[run.run_id] > self._times.grace for run in runs):
                self._pool.kill(worker)
                self._store.release(cohort.claim, "its worker was ended to cancel a neighbour")
                del self._cohorts[worker]

    def _give_up_silent(self) -> None:
        """End workers that were not heard of for as long as their lease."""
        for worker, cohort in list(self._cohorts.items()):
            silent = self._clock() - cohort.heard_at
            if silent > self._times.lease:
                self._pool.kill(worker)
                self._store.lose(cohort.claim, f"its worker was silent for {silent:.0f} s")
                del self._cohorts[worker]

    def _requeue_expired(self) -> None:
        if self._clock() >= self._expiry_at:
            self._store.lose_expired()
            self._expiry_at = self._clock() + self._times.expiry

    def _hand_out(self) -> None:
        """Claim a cohort for each idle worker, an even share of what waits."""
        while self._idle and (waiting := self._store.waiting_runs()):
            share = min(math.ceil(waiting / len(self._idle)), COHORT_LIMIT)
            worker = next(iter(self._idle))
            measured = {
                *self._store.random_returns(),
                *(cohort.measures for cohort in self._cohorts.values()),
            }
            claim = self._store.claim_cohort(worker, self._times.lease, share)
            if claim is None:
                return
            first = claim.runs[0]
            version = (first.spec.environment, first.environment_version)
            measures = None if version in measured else version
            del self._idle[worker]
            self._cohorts[worker] = _Cohort(claim, self._clock(), measures)
            self._pool.train(worker, claim.specs, measure_random_return=measures is not None)
