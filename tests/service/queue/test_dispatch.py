"""Dispatch: whatever happens to workers, every run ends truthfully and its curve is whole."""

import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
from sqlalchemy.exc import OperationalError

from service.model.claim import Claim
from service.model.run import Run, RunStatus
from service.model.sweep import RunCounts, Sweep
from service.queue.dispatch import Dispatcher
from service.queue.dispatch_state import DispatchTimes
from service.store.claiming.retry import RetryPolicy
from service.store.store import Store
from tests.service.fake_pool import CYCLE, FakePool, measurement_of
from workers.messages.assignment import Assignment
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

TIMESTEPS = 4 * CYCLE
TIMES = DispatchTimes(lease=15.0, grace=5.0, round=0.0, expiry=0.0, restart=1.0)


class Clock:
    """Time as the test says."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}", RetryPolicy(3, 0.0))
    yield opened
    opened.close()


@pytest.fixture
def pool() -> FakePool:
    return FakePool()


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def dispatcher(store: Store, pool: FakePool, clock: Clock) -> Dispatcher:
    return Dispatcher(store, pool, TIMES, clock)


def submit(store: Store, seeds: int = 4, environments: tuple[str, ...] = ("Pendulum",)) -> Sweep:
    specs = [
        RunSpec("ddpg", environment, seed, timesteps=TIMESTEPS)
        for environment in environments
        for seed in range(seeds)
    ]
    versions = dict.fromkeys(environments, 1)
    return store.create_sweep("x", 0, {}, specs, environment_versions=versions)


def counts(store: Store, sweep: Sweep) -> RunCounts:
    found = store.find_sweep(sweep.id)
    assert found is not None
    return found.runs


def run_of(store: Store, sweep: Sweep, ordinal: int) -> Run:
    run = store.find_run(f"{sweep.id}-{ordinal}")
    assert run is not None
    return run


def problem_of(dispatcher: Dispatcher) -> str:
    return dispatcher.problem or ""


def work(dispatcher: Dispatcher, rounds: int) -> None:
    for _ in range(rounds):
        dispatcher.work_round()


def wait(dispatcher: Dispatcher, clock: Clock, seconds: int) -> None:
    """Let time pass for a dispatcher that listens all the while."""
    for _ in range(seconds):
        clock.now += 1.0
        dispatcher.work_round()


def work_until(dispatcher: Dispatcher, is_over: Callable[[], bool], rounds: int = 100) -> None:
    for _ in range(rounds):
        if is_over():
            return
        dispatcher.work_round()
    raise AssertionError(f"not over after {rounds} rounds")


def wait_for(is_so: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 30
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def assert_whole(store: Store, sweep: Sweep) -> None:
    """Every run succeeded, and has each of its measurements once."""
    for run in store.list_runs(sweep.id):
        assert run.status is RunStatus.SUCCEEDED, run
        expected = [
            measurement_of(run.spec.seed, timestep)
            for timestep in range(CYCLE, TIMESTEPS + 1, CYCLE)
        ]
        assert store.measurements(run.id) == expected


def test_a_sweep_is_trained(dispatcher: Dispatcher, store: Store) -> None:
    sweep = submit(store, 4, ("Pendulum", "MassPoint"))
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)
    assert all(run.attempt == 1 for run in store.list_runs(sweep.id))
    assert dispatcher.workers == {"worker-1": False, "worker-2": False}


def test_idle_workers_share_what_waits(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    submit(store, 16)
    work(dispatcher, 2)
    assert [len(worker.specs) for worker in pool.workers.values()] == [8, 8]


def test_a_random_return_is_measured_once_per_task(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    sweep = submit(store, 1, ("Pendulum", "MassPoint"))
    again = submit(store, 1, ("Pendulum", "MassPoint"))
    work_until(dispatcher, lambda: counts(store, sweep).active + counts(store, again).active == 0)
    assert sorted(pool.asked_random_returns) == ["MassPoint", "Pendulum"]
    assert set(store.random_returns()) == {("Pendulum", 1), ("MassPoint", 1)}


def test_a_dead_workers_cohort_completes_elsewhere(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    sweep = submit(store)
    work(dispatcher, 4)
    victim = next(iter(pool.workers))
    assert pool.workers[victim].specs
    pool.crash(victim)
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)
    assert sorted(run.attempt for run in store.list_runs(sweep.id)) == [1, 1, 2, 2]
    [lost] = [run for run in store.list_runs(sweep.id) if run.attempt == 2][:1]
    first, second = store.attempts(lost.id)
    assert (first.outcome, first.worker, first.log_tail) == ("lost", victim, "last words")
    assert second.outcome == "succeeded"


def test_workers_that_die_every_time_are_not_fed_for_ever(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    sweep = submit(store, 2)
    for _ in range(30):
        dispatcher.work_round()
        for worker in list(pool.workers.values()):
            if worker.specs:
                pool.crash(worker.name)
    assert counts(store, sweep) == RunCounts(failed=2)
    assert "given up after losing 4 workers in a row" in run_of(store, sweep, 0).reason


def test_a_silent_worker_is_given_up(
    dispatcher: Dispatcher, store: Store, pool: FakePool, clock: Clock
) -> None:
    sweep = submit(store, 2)
    work(dispatcher, 3)
    frozen = next(iter(pool.workers.values()))
    frozen.is_frozen = True
    wait(dispatcher, clock, 15)
    assert frozen.name in pool.workers
    wait(dispatcher, clock, 1)
    assert frozen.name not in pool.workers  # its process was ended
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)
    lost = [run for run in store.list_runs(sweep.id) if run.attempt == 2]
    assert store.attempts(lost[0].id)[0].error == "its worker was silent for 16 s"


def test_a_service_that_was_frozen_blames_no_worker(
    dispatcher: Dispatcher, store: Store, clock: Clock
) -> None:
    sweep = submit(store, 4)
    work(dispatcher, 3)
    clock.now += 3600.0
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)
    assert all(run.attempt == 1 for run in store.list_runs(sweep.id))


def test_diverged_runs_end_and_their_neighbours_go_on(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    pool.diverging = {1}
    sweep = submit(store, 4)
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert counts(store, sweep) == RunCounts(succeeded=3, diverged=1)
    run = run_of(store, sweep, 1)
    assert run.reason == "critic loss stopped being finite at update 7, timestep 1600"
    assert run.attempt == 1
    assert store.measurements(run.id) == [measurement_of(1, CYCLE)]


def test_an_error_in_code_is_not_tried_again(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    pool.raising = {0}
    sweep = submit(store, 1)
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    run = run_of(store, sweep, 0)
    assert (run.status, run.reason, run.attempt) == (RunStatus.FAILED, "ValueError: x", 1)
    assert store.attempts(run.id)[0].log_tail == "output"
    assert dispatcher.workers == {"worker-1": False, "worker-2": False}  # none was lost


def test_a_cancelled_run_leaves_its_cohort(dispatcher: Dispatcher, store: Store) -> None:
    sweep = submit(store, 4)
    work(dispatcher, 3)
    store.move_run(f"{sweep.id}-2", "cancel")
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert counts(store, sweep) == RunCounts(succeeded=3, cancelled=1)
    assert all(run.attempt == 1 for run in store.list_runs(sweep.id))


def test_a_worker_that_does_not_drop_is_ended(
    dispatcher: Dispatcher, store: Store, pool: FakePool, clock: Clock
) -> None:
    sweep = submit(store, 4)
    work(dispatcher, 3)
    for worker in pool.workers.values():
        worker.is_deaf = True
    store.move_run(f"{sweep.id}-0", "cancel")
    work(dispatcher, 1)
    assert run_of(store, sweep, 0).is_cancelling
    clock.now += 6.0
    work(dispatcher, 1)
    assert run_of(store, sweep, 0).status is RunStatus.CANCELLED
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert counts(store, sweep) == RunCounts(succeeded=3, cancelled=1)
    neighbour = run_of(store, sweep, 1)
    assert neighbour.attempt == 2
    assert (
        store.attempts(neighbour.id)[0].error
        == "its worker was ended to cancel another of its runs"
    )


def test_none_starts_after_its_sweep_was_cancelled(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    sweep = submit(store, 40)
    work(dispatcher, 2)
    running = counts(store, sweep).running
    store.move_sweep(sweep.id, "cancel")
    work(dispatcher, 5)
    assert counts(store, sweep) == RunCounts(cancelled=40)
    assert sum(run.attempt for run in store.list_runs(sweep.id)) == running
    assert not any(worker.specs for worker in pool.workers.values())


def test_what_a_killed_server_left_is_claimed_again(
    dispatcher: Dispatcher, store: Store, clock: Clock
) -> None:
    sweep = submit(store, 2)
    forgotten = store.claim_cohort("worker of a server that was killed", -1.0)
    assert isinstance(forgotten, Claim)
    early = Progress(CYCLE, measurements=(measurement_of(0, CYCLE), measurement_of(1, CYCLE)))
    store.record(Claim("w", -1.0, forgotten.runs), early)
    wait(dispatcher, clock, 14)  # the worker may yet be heard of
    assert [run.attempt for run in store.list_runs(sweep.id)] == [1, 1]
    wait(dispatcher, clock, 2)
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)
    assert [run.attempt for run in store.list_runs(sweep.id)] == [2, 2]


def test_runs_taken_away_from_a_worker_are_dropped_by_it(
    dispatcher: Dispatcher, store: Store, pool: FakePool
) -> None:
    sweep = submit(store, 1)
    work(dispatcher, 2)
    [busy] = [worker for worker in pool.workers.values() if worker.specs]
    run = run_of(store, sweep, 0)
    same = Assignment(run.id, run.attempt, run.spec, run.environment_version)
    store.lose(Claim("w", 15.0, (same,)), "its lease ended")
    assert run_of(store, sweep, 0).status is RunStatus.QUEUED
    work(dispatcher, 2)
    assert not busy.specs or busy.timestep == CYCLE  # stopped, or begun anew
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)


def test_says_why_no_run_can_start(
    dispatcher: Dispatcher, store: Store, pool: FakePool, clock: Clock
) -> None:
    sweep = submit(store, 1)
    assert problem_of(dispatcher) == "the cluster is starting"
    pool.problem = "Failed to connect to Ray at 10.0.0.1:6379"
    work(dispatcher, 3)
    assert problem_of(dispatcher).startswith("the cluster has been unreachable since ")
    assert "Failed to connect to Ray at 10.0.0.1:6379" in problem_of(dispatcher)
    assert pool.starts == 1  # waits before it tries again
    clock.now += 2.0
    pool.problem = ""
    work(dispatcher, 2)
    assert not problem_of(dispatcher)
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)


def test_a_cluster_that_dies_and_comes_back(
    dispatcher: Dispatcher, store: Store, pool: FakePool, clock: Clock
) -> None:
    sweep = submit(store, 4)
    work(dispatcher, 3)
    pool.problem = "the head is gone"
    work(dispatcher, 1)
    assert counts(store, sweep) == RunCounts(queued=4)
    assert dispatcher.workers == {}
    pool.problem = ""
    clock.now += 2.0
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)


def test_nothing_is_lost_while_the_database_refuses(
    dispatcher: Dispatcher, store: Store, monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    sweep = submit(store, 4)
    work(dispatcher, 3)

    def refuse(said: Sequence[tuple[Claim, Progress]]) -> list[set[str]]:
        del said
        raise OperationalError("INSERT", {}, Exception("database or disk is full"))

    with monkeypatch.context() as patched:
        patched.setattr(store, "record_all", refuse)
        for _ in range(5):
            clock.now += 10.0
            with pytest.raises(OperationalError, match="disk is full"):
                dispatcher.work_round()
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert_whole(store, sweep)
    assert all(run.attempt == 1 for run in store.list_runs(sweep.id))


def test_the_thread_says_that_the_database_refuses_and_recovers(
    store: Store, pool: FakePool, monkeypatch: pytest.MonkeyPatch
) -> None:
    dispatcher = Dispatcher(store, pool, TIMES)
    refused = OperationalError("SELECT", {}, Exception("disk I/O error"))

    def refuse(limit: int) -> int:
        raise refused

    monkeypatch.setattr(store, "waiting_cells", refuse)
    dispatcher.start()
    try:
        wait_for(lambda: "disk I/O error" in problem_of(dispatcher))
        monkeypatch.undo()
        sweep = submit(store, 2)
        wait_for(lambda: counts(store, sweep).active == 0)
        assert not problem_of(dispatcher)
    finally:
        dispatcher.stop()
    assert_whole(store, sweep)


def test_what_all_workers_say_in_a_round_is_one_transaction(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    pool = FakePool(size=20)
    dispatcher = Dispatcher(store, pool, TIMES, Clock())
    sweep = submit(store, 20)
    sizes = []

    def record_all(said: Sequence[tuple[Claim, Progress]]) -> list[set[str]]:
        sizes.append(len(said))
        return Store.record_all(store, said)

    monkeypatch.setattr(store, "record_all", record_all)
    work_until(dispatcher, lambda: counts(store, sweep).active == 0)
    assert sizes == [20] * (TIMESTEPS // CYCLE)
    assert_whole(store, sweep)
    assert pool.acknowledged == 20 * (1 + 1 + TIMESTEPS // CYCLE + 1)  # ready, busy, news, ended


def test_stopping_puts_runs_back_and_closes_the_pool(store: Store, pool: FakePool) -> None:
    dispatcher = Dispatcher(store, pool, TIMES)
    sweep = submit(store, 2)
    pool.is_freezing = True
    dispatcher.start()
    wait_for(lambda: counts(store, sweep).running == 2)
    dispatcher.stop()
    assert pool.is_closed
    assert counts(store, sweep) == RunCounts(queued=2)
    assert run_of(store, sweep, 0).reason == "the service was stopped"


def test_reports_are_gathered_the_longer_the_more_workers_there_are(
    store: Store, clock: Clock
) -> None:
    times = DispatchTimes(round=0.0, gather=0.25, longest_gather=0.6)
    for size, seconds in ((0, 0.0), (1, 0.25), (2, 0.5), (3, 0.6)):
        pool = FakePool(size)
        dispatcher = Dispatcher(store, pool, times, clock)
        for _ in range(3):
            dispatcher.work_round()
        assert pool.gathered[-1] == seconds


def test_a_few_workers_are_hardly_waited_for() -> None:
    times = DispatchTimes()
    assert times.gathering(16) < 0.005
    assert times.gathering(10_000) == times.longest_gather <= times.round
