"""Dispatch: between the queue in the store and the workers of a pool.

One thread repeats a round: it passes the reports of the pool and then a tick to the scheduler
(`service/queue/scheduler.py`), and runs the commands that the scheduler returns. Reports of several
workers are written in one transaction, and their next runs are claimed in one. The store is the
record; the state kept here can be lost at any time: then every lease runs out, and every run is
claimed again.

A command that the database refuses (a full disk) is tried again, and everything after it waits.
"""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace

import structlog

from physics.task_file import TaskFile
from service.metrics import DISPATCH_SECONDS
from service.model.claim import CellLimit, no_limit
from service.queue.batch import next_together, take_next
from service.queue.dispatch_state import DispatchTimes, State
from service.queue.messages import (
    AskCancelling,
    AskWaiting,
    Cancelling,
    ClaimCohort,
    Claimed,
    Command,
    Demand,
    Drop,
    Fail,
    Kill,
    Lose,
    LoseExpired,
    PoolLost,
    QueueEvent,
    Record,
    Recorded,
    Release,
    StartPool,
    Tick,
    Train,
    Waiting,
)
from service.queue.scheduler import step
from service.store.store import Store
from service.store.upkeep.trouble import explain
from workers.messages.work import Work
from workers.pool.pool import Pool, PoolUnavailableError

log = structlog.get_logger(__name__)

FileOf = Callable[[str, int], TaskFile | None]


def no_file(environment: str, version: int) -> None:
    """No environment is of a task file."""
    del environment, version


class Dispatcher:
    """Assigns runs to workers and records their results. `start` begins, `stop` ends in order."""

    def __init__(
        self,
        store: Store,
        pool: Pool,
        times: DispatchTimes | None = None,
        clock: Callable[[], float] = time.monotonic,
        limit_of: CellLimit = no_limit,
        file_of: FileOf = no_file,
    ) -> None:
        """Begin nothing yet; the clock is for tests. A cohort is within its cell's limit.

        `file_of` has the task file of a version of an environment: it goes with the work.
        """
        self._file_of = file_of
        self._store = store
        self._pool = pool
        self._limit_of = limit_of
        self._times = times or DispatchTimes()
        self._clock = clock
        self._state = State()
        self._events: deque[QueueEvent] = deque()
        self._commands: deque[Command] = deque()
        self._reports_in_hand = 0
        self._store_problem = ""
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
        return self._store_problem or self._state.problem or None

    @property
    def workers(self) -> dict[str, bool]:
        """The workers that are up, and whether each is busy."""
        state = self._state  # one value, whatever the thread does meanwhile
        return {**dict.fromkeys(state.idle, False), **dict.fromkeys(state.cohorts, True)}

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self.work_round()
                self._store_problem = ""
            except Exception as error:  # a full disk, a database that restarts: tried again
                if not self._store_problem:
                    log.exception("dispatch is held up")
                self._store_problem = f"the database refuses: {explain(error)}"
                self._stopping.wait(1.0)
        self._close()

    def _close(self) -> None:
        try:
            self._listen()
            self._take_in()
        except Exception:  # it will be measured again
            log.exception("the last reports could not be recorded")
        for cohort in self._state.cohorts.values():
            try:
                self._store.release(cohort.claim, "the service was stopped")
            except Exception:  # its lease runs out by itself
                log.exception("a claim could not be released")
        self._pool.close()

    def work_round(self) -> None:
        """Do one round. Raises what the store raises; nothing is lost then."""
        self._listen()
        with DISPATCH_SECONDS.time():
            self._carry_out()
            self._take_in()
            self._advance(Tick())
            self._carry_out()

    def _take_in(self) -> None:
        """Pass reports to the scheduler; once they are recorded, the pool need not keep them."""
        while self._events:
            taken = take_next(self._events)
            self._reports_in_hand += sum(not isinstance(event, PoolLost) for event in taken)
            self._advance(*taken)
            self._carry_out()
        if self._reports_in_hand and self._state.pool_is_up:
            self._pool.acknowledge(self._reports_in_hand)
        self._reports_in_hand = 0

    def _listen(self) -> None:
        """Wait for reports, also while the database refuses, so that only workers can be silent."""
        is_held_up = bool(self._events or self._commands)
        if not self._state.pool_is_up or PoolLost in map(type, self._events):
            self._stopping.wait(0.0 if is_held_up else self._times.round)
            return
        wait = 0.0 if is_held_up else self._times.round
        gather = self._times.gathering(len(self.workers))
        try:
            self._events.extend(self._pool.reports(wait, gather))
        except PoolUnavailableError as error:
            self._events.append(_pool_lost(error))

    def _advance(self, *events: QueueEvent) -> None:
        """Pass events to the scheduler, and put its commands first."""
        commands: list[Command] = []
        for event in events:
            self._state, more = step(self._state, event, self._clock(), self._times)
            commands += more
        self._commands.extendleft(reversed(commands))

    def _carry_out(self) -> None:
        """Run the commands. A finished command is removed, and its answer is the next event."""
        while self._commands:
            together = next_together(self._commands)
            answers = self._do(together)
            for _ in together:
                self._commands.popleft()
            self._advance(*answers)

    def _do(self, together: list[Command]) -> list[QueueEvent]:
        records = [command for command in together if isinstance(command, Record)]
        if records:
            return self._record(records)
        claims = [command for command in together if isinstance(command, ClaimCohort)]
        if claims:
            return self._claim(claims)
        answer = self._do_one(together[0])
        return [] if answer is None else [answer]

    def _record(self, records: list[Record]) -> list[QueueEvent]:
        held = self._store.record_all([(each.claim, each.news.progress) for each in records])
        return [
            Recorded(each.news, frozenset(runs)) for each, runs in zip(records, held, strict=True)
        ]

    def _claim(self, claims: list[ClaimCohort]) -> list[QueueEvent]:
        asked = [(each.worker, each.limit) for each in claims]
        found = self._store.claim_all(asked, claims[0].lease_seconds, self._limit_of)
        return [Claimed(each.worker, claim) for each, claim in zip(claims, found, strict=True)]

    def _do_one(self, command: Command) -> QueueEvent | None:
        match command:
            case Lose(claim, reason, log_tail):
                self._store.lose(claim, reason, log_tail)
            case Release(claim, reason):
                self._store.release(claim, reason)
            case Fail(claim, error, log_tail):
                self._store.fail(claim, error, log_tail)
            case LoseExpired():
                self._store.lose_expired()
            case AskCancelling():
                return Cancelling(frozenset(self._store.cancelling_runs()))
            case AskWaiting(limit):
                return self._count_waiting(limit)
            case Demand(workers):
                self._pool.demand(workers)
            case Train(worker, work):
                self._pool.train(worker, self._with_file(work))
            case Drop(worker, seeds):
                self._pool.drop(worker, seeds)
            case Kill(worker):
                self._pool.kill(worker)
            case StartPool():
                return self._start_pool()
        return None

    def _with_file(self, work: Work) -> Work:
        run = work.runs[0]
        return replace(work, file=self._file_of(run.spec.environment, run.environment_version))

    def _count_waiting(self, limit: int) -> Waiting:
        cells = tuple(self._store.waiting_cells(limit))
        known = self._store.random_returns() if cells else ()
        return Waiting(cells, limit, frozenset(known))

    def _start_pool(self) -> PoolLost | None:
        try:
            self._pool.start()
        except PoolUnavailableError as error:
            return _pool_lost(error)
        return None


def _pool_lost(error: PoolUnavailableError) -> PoolLost:
    log.warning("the cluster is unreachable", reason=str(error))
    return PoolLost(str(error), time.strftime("%H:%M:%S"))
