"""The queue's decisions, as a pure state machine.

    step: (state, event, now) -> (state, commands)

Events are reports of the pool, answers of the store, and ticks; commands are writes and queries to
the store, and orders to the pool (`service/queue/messages.py`). There is no thread, no clock and no
store in here: `service/queue/dispatch.py` runs the commands.

The answer to a command is the next event. A command to the store may be run again if its answer was
lost: every write is fenced by the attempts of its claim, so a second one changes nothing, and a
claim whose answer was lost ends with its lease. For this reason, the state kept here can be lost at
any time.
"""

import math
from dataclasses import replace

from service.model.claim import Claim
from service.queue.cohort_size import cohort_size, cohorts
from service.queue.dispatch_state import Cohort, DispatchTimes, State
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
from workers.messages.report import Busy, Capacity, Ended, Failed, Lost, News, Ready, Retired
from workers.messages.run_spec import COHORT_LIMIT
from workers.messages.work import Work

REPORTS_A_SECOND = 200
"""Of all workers together. Where there are more, each reports less often: what they measure comes
in fewer transactions, and the cost of a report is for the most part one of its sixteen runs."""
WORKERS_STARTING = "the cluster's workers are starting"
NO_ROOM = (
    "the cluster has no room to train: runs wait until a node has joined it, or its autoscaler has "
    "added one, with a core (`ray start --address=... --num-cpus=...`) and, where "
    "D3PG_WORKER_MEMORY is set, with that much memory and 300 MB"
)

DEMANDED_COHORTS = 256
"""Waiting runs are counted up to this number, which limits the workers asked for at a time."""


Step = tuple[State, list[Command]]


def step(  # noqa: PLR0911, PLR0912  (one an event)
    state: State, event: QueueEvent, now: float, times: DispatchTimes
) -> Step:
    """Take one event into account, and return the commands."""
    match event:
        case Tick():
            return _tick(state, now, times)
        case Ready(worker):
            known = worker in state.idle or worker in state.cohorts
            return state.up() if known else state.up().freeing(worker), []
        case Busy(worker, work) if worker not in state.cohorts:
            claim = Claim(worker, work.lease_seconds, work.runs)
            return state.up().training(worker, Cohort(work.cohort, claim, now)), []
        case News(worker, cohort) if state.trains(worker, cohort):
            heard = replace(state.cohorts[worker], heard_at=now)
            return state.training(worker, heard), [Record(heard.claim, event)]
        case Recorded(news) if state.trains(news.worker, news.cohort):
            return _recorded(state, event)
        case Ended(worker, cohort) if state.trains(worker, cohort):
            claim = state.cohorts[worker].claim
            lose = Lose(claim, "its worker ended before the run did")
            return state.freeing(worker), [lose] if claim.runs else []
        case Failed(worker, cohort, error, log_tail) if state.trains(worker, cohort):
            fail = Fail(state.cohorts[worker].claim, error, log_tail)
            return state.freeing(worker), [fail]
        case Lost(worker, reason, log_tail):
            return _lost(state, worker, reason, log_tail)
        case Retired(worker):
            return _retired(state, worker)
        case Capacity():
            return _room(state, event), []
        case PoolLost():
            return _pool_lost(state, event, now, times)
        case Cancelling(runs):
            return _cancel(state, runs, now, times)
        case Waiting():
            return _waiting(state, event, times)
        case Claimed(worker, claim):
            return _claimed(state, worker, claim, now, times)
        case _:  # of a cohort that was given up, or heard before
            return state, []


def _tick(state: State, now: float, times: DispatchTimes) -> Step:
    """Do what is due: start the pool, give up silent workers, look for changes in the store."""
    commands: list[Command] = []
    if not state.pool_is_up and now >= state.restart_at:
        state = replace(state, pool_is_up=True)
        commands.append(StartPool())
    state = _forgive_the_unheard(state, now, times)
    for worker, cohort in state.cohorts.items():
        if (silent := now - cohort.heard_at) > times.lease:
            state = state.without(worker)
            reason = f"its worker was silent for {silent:.0f} s"
            commands += [Kill(worker), Lose(cohort.claim, reason)]
    if state.cohorts:
        commands.append(AskCancelling())
    if now >= state.expiry_at:
        state = replace(state, expiry_at=now + times.expiry)
        commands.append(LoseExpired())
    is_due = now >= state.demand_at
    if is_due:
        state = replace(state, demand_at=now + times.demand)
    if is_due or state.idle:
        commands.append(_ask_waiting(state, DEMANDED_COHORTS if is_due else 0))
    return replace(state, ticked_at=now), commands


def _forgive_the_unheard(state: State, now: float, times: DispatchTimes) -> State:
    """Discount time in which this process did not listen: no lease could be renewed in it.

    That is the time before the first tick, and while this process was frozen.
    """
    deaf = math.inf if state.ticked_at is None else now - state.ticked_at
    if deaf <= times.lease / 3:
        return state
    cohorts = {
        worker: replace(cohort, heard_at=max(cohort.heard_at, now))
        for worker, cohort in state.cohorts.items()
    }
    return replace(state, cohorts=cohorts, expiry_at=now + times.lease)


# ---- what the pool says


def _recorded(state: State, recorded: Recorded) -> Step:
    """Stop the training of runs that this service holds no longer."""
    worker, progress = recorded.news.worker, recorded.news.progress
    cohort = state.cohorts[worker]
    taken_away = (
        frozenset(run.spec.seed for run in cohort.claim.runs if run.run_id not in recorded.held)
        - progress.gone
    )
    kept = replace(cohort, claim=cohort.claim.only(recorded.held))
    return state.training(worker, kept), [Drop(worker, taken_away)] if taken_away else []


def _room(state: State, room: Capacity) -> State:
    """Take the room of the cluster into account; its workers may not have started yet."""
    state = replace(state.up(), capacity=room.workers)
    if not room.workers:
        return replace(state, problem=NO_ROOM)
    is_starting = room.slots and not (state.idle or state.cohorts)
    return replace(state, problem=WORKERS_STARTING if is_starting else "")


def _retired(state: State, worker: str) -> Step:
    """Queue at once what the worker was given too late."""
    cohort = state.cohorts.get(worker)
    reason = "its worker was retired before the run began"
    return state.without(worker), [] if cohort is None else [Release(cohort.claim, reason)]


def _lost(state: State, worker: str, reason: str, log_tail: str) -> Step:
    cohort = state.cohorts.get(worker)
    return state.without(worker), [] if cohort is None else [Lose(cohort.claim, reason, log_tail)]


def _pool_lost(state: State, lost: PoolLost, now: float, times: DispatchTimes) -> Step:
    """Lose every worker with its pool, which is started again after a pause."""
    reason = "its worker was lost with the cluster"
    commands: list[Command] = [Lose(cohort.claim, reason) for cohort in state.cohorts.values()]
    since = state.lost_since or lost.noticed
    wait = state.restart_wait or times.restart
    gone = replace(
        state,
        idle=(),
        cohorts={},
        pool_is_up=False,
        problem=f"the cluster has been unreachable since {since}: {lost.reason}",
        lost_since=since,
        restart_at=now + wait,
        restart_wait=min(2 * wait, times.longest_restart),
        capacity=0,
        demand=None,
    )
    return gone, commands


# ---- what the store says


def _cancel(state: State, runs: frozenset[str], now: float, times: DispatchTimes) -> Step:
    """Let workers drop cancelled runs; end workers that did not do so within the grace."""
    commands: list[Command] = []
    for worker, cohort in state.cohorts.items() if runs else ():
        asked = {run.run_id: run.spec.seed for run in cohort.claim.runs if run.run_id in runs}
        if any(now - cohort.dropped.get(run, now) > times.grace for run in asked):
            state = state.without(worker)
            reason = "its worker was ended to cancel another of its runs"
            commands += [Kill(worker), Release(cohort.claim, reason)]
        elif fresh := asked.keys() - cohort.dropped.keys():
            dropped = {**cohort.dropped, **dict.fromkeys(fresh, now)}
            state = state.training(worker, replace(cohort, dropped=dropped))
            commands.append(Drop(worker, frozenset(asked[run] for run in fresh)))
    return state, commands


def _waiting(state: State, waiting: Waiting, times: DispatchTimes) -> Step:
    """Claim for idle workers, the longest idle first; tell for how many workers there is work."""
    state = replace(state, random_returns=waiting.random_returns)
    size = cohort_size(waiting.cells, state.free_cores)
    ready = cohorts(waiting.cells, size)
    demand = len(state.cohorts) + ready
    commands: list[Command] = []
    is_counted = sum(waiting.cells) < waiting.limit or demand > (state.demand or 0)
    if state.pool_is_up and is_counted and demand != state.demand:
        state = replace(state, demand=demand)
        commands.append(Demand(demand))
    commands += [ClaimCohort(worker, times.lease, size) for worker in state.idle[:ready]]
    return state, commands


def _claimed(
    state: State, worker: str, claim: Claim | None, now: float, times: DispatchTimes
) -> Step:
    """Let the worker train the claim."""
    if claim is None:
        return state, []
    if worker not in state.idle:
        return state, [Release(claim, "its worker was lost before the run began")]
    first = claim.runs[0]
    version = (first.spec.environment, first.environment_version)
    in_measurement = {cohort.measures for cohort in state.cohorts.values()}
    is_known = version in state.random_returns or version in in_measurement
    cohort = Cohort(claim.name, claim, now, None if is_known else version)
    state = state.training(worker, cohort)
    work = Work(
        cohort.name,
        claim.runs,
        claim.lease_seconds,
        measure_random_return=not is_known,
        report_seconds=_report_seconds(state, times),
    )
    return state, [Train(worker, work)]


def _report_seconds(state: State, times: DispatchTimes) -> float:
    """The time between reports of a worker, so that all workers together do not report too much."""
    workers = len(state.idle) + len(state.cohorts)
    return min(max(times.report, workers / REPORTS_A_SECOND), times.longest_report)


def _ask_waiting(state: State, cohorts: int = 0) -> AskWaiting:
    """Count as many runs as the free cores, or so many workers, could have at once."""
    return AskWaiting(max(state.free_cores, cohorts) * COHORT_LIMIT)
