"""Pausing, resuming and retrying sweeps and runs: what moves, what stays, what is refused."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from service.model.move import Move
from service.model.run import RunStatus
from service.model.sweep import RunCounts, SweepStatus
from service.store.refusal import ImpossibleMoveError, SubmissionKeyReusedError
from service.store.store import Store
from tests.service.store.conftest import AT_ONCE, Submit, measured
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

LEASE = 60.0


def counts(store: Store, sweep_id: str) -> RunCounts:
    sweep = store.find_sweep(sweep_id)
    assert sweep is not None
    return sweep.runs


def status(store: Store, run_id: str) -> RunStatus:
    run = store.find_run(run_id)
    assert run is not None
    return run.status


def test_a_paused_sweep_starts_nothing_and_what_runs_goes_on(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=4)
    claim = store.claim_cohort("w", LEASE, 2)
    assert claim is not None
    for _ in range(2):  # again: no error, no change
        paused = store.move_sweep(sweep.id, "pause")
        assert (paused.status, paused.runs) == (SweepStatus.PAUSED, RunCounts(paused=2, running=2))
        assert paused.eta_seconds is None
    assert store.claim_cohort("w", LEASE) is None
    assert store.waiting_cells(limit=100) == []
    assert store.record(claim, Progress(1600, finished=(0,))) == {f"{sweep.id}-1"}
    store.lose(claim, "its worker was lost")
    assert counts(store, sweep.id) == RunCounts(paused=3, succeeded=1)  # lost runs wait as well
    for _ in range(2):
        resumed = store.move_sweep(sweep.id, "resume")
        assert resumed.runs == RunCounts(queued=3, succeeded=1)
    assert store.claim_cohort("w", LEASE) is not None


def test_one_run_is_paused_alone(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    paused = f"{sweep.id}-0"
    for _ in range(2):
        assert store.move_run(paused, "pause").status is RunStatus.PAUSED
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    assert [run.run_id for run in claim.runs] == [f"{sweep.id}-1"]
    with pytest.raises(ImpossibleMoveError, match="is running: a pause keeps queued runs"):
        store.move_run(f"{sweep.id}-1", "pause")
    for _ in range(2):
        assert store.move_run(paused, "resume").status is RunStatus.QUEUED
    store.move_sweep(sweep.id, "pause")
    with pytest.raises(ImpossibleMoveError, match="resume it, not one of its runs"):
        store.move_run(paused, "resume")
    store.move_run(paused, "cancel")
    with pytest.raises(ImpossibleMoveError, match="already been cancelled"):
        store.move_run(paused, "resume")


def test_a_paused_sweep_is_cancelled_whole(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3)
    store.move_sweep(sweep.id, "pause")
    ended = store.move_sweep(sweep.id, "cancel")
    assert (ended.status, ended.runs) == (SweepStatus.CANCELLED, RunCounts(cancelled=3))
    moves: tuple[Move, ...] = ("pause", "resume", "retry")
    for asked in moves:
        with pytest.raises(ImpossibleMoveError, match="cancelled"):
            store.move_sweep(sweep.id, asked)


def test_only_what_failed_is_tried_again(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.record(claim, Progress(1600, measurements=(measured(2, 800),), finished=(0,)))
    store.fail(claim, "ValueError: no", "the log's end")
    with pytest.raises(ImpossibleMoveError, match="has succeeded: only failed runs"):
        store.move_run(f"{sweep.id}-0", "retry")
    assert counts(store, sweep.id) == RunCounts(succeeded=1, failed=2)

    assert store.move_run(f"{sweep.id}-1", "retry").status is RunStatus.QUEUED
    assert store.move_run(f"{sweep.id}-1", "retry").status is RunStatus.QUEUED  # again: no error
    assert store.move_sweep(sweep.id, "retry").runs == RunCounts(queued=2, succeeded=1)
    kept = store.attempts(f"{sweep.id}-2")
    assert [attempt.log_tail for attempt in kept] == ["the log's end"]
    assert [m.timestep for m in store.measurements(f"{sweep.id}-2")] == [800]

    again = store.claim_cohort("w", LEASE)
    assert again is not None
    assert [run.attempt for run in again.runs] == [2, 2]
    store.record(again, Progress(1600, finished=(1, 2)))
    assert counts(store, sweep.id) == RunCounts(succeeded=3)
    with pytest.raises(ImpossibleMoveError, match="none of its runs has failed"):
        store.move_sweep(sweep.id, "retry")


def test_a_retried_run_of_a_paused_sweep_waits_with_it(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    claim = store.claim_cohort("w", LEASE, 1)
    assert claim is not None
    store.fail(claim, "ValueError: no")
    store.move_sweep(sweep.id, "pause")
    store.move_sweep(sweep.id, "retry")
    assert counts(store, sweep.id) == RunCounts(paused=2)
    assert status(store, f"{sweep.id}-0") is RunStatus.PAUSED


def test_each_move_is_told(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1)
    start = store.last_event_id()
    store.move_sweep(sweep.id, "pause")
    store.move_sweep(sweep.id, "resume")
    told = [(e.kind, e.payload.get("change", e.payload.get("status"))) for e in
            store.events_after(start)]  # fmt: skip
    assert told == [("sweep", "paused"), ("run", "paused"), ("sweep", "resumed"), ("run", "queued")]


def test_a_key_stands_for_one_sweep(store: Store) -> None:
    def create(key: str | None, seeds: int = 2) -> str:
        specs = [RunSpec("ddpg", "Pendulum", seed) for seed in range(seeds)]
        request = {"name": "x", "seeds": seeds}
        return store.create_sweep(
            "x", 0, request, specs, environment_versions={"Pendulum": 1}, submission_key=key
        ).id

    first = create("a key")
    assert create("a key") == first
    assert len(store.list_sweeps()) == 1
    assert create("another") != first
    assert create(None) != create(None)
    with pytest.raises(SubmissionKeyReusedError, match=f"sweep {first} was submitted"):
        create("a key", seeds=3)
    assert counts(store, first) == RunCounts(queued=2)


def test_nothing_starts_once_a_sweep_that_is_being_claimed_was_cancelled(
    store: Store, submit: Submit
) -> None:
    """Eight claimers against a cancel in their midst: afterwards no claim succeeds."""
    sweep = submit(seeds=2000)
    begun, cancelled = threading.Barrier(9), threading.Event()

    def claim_all() -> int:
        late = 0
        begun.wait(10)
        while True:
            is_late = cancelled.is_set()
            claim = store.claim_cohort("w", LEASE)
            if claim is None:
                return late
            late += is_late

    with ThreadPoolExecutor(8) as pool:
        claimers = [pool.submit(claim_all) for _ in range(8)]
        begun.wait(10)
        left = store.move_sweep(sweep.id, "cancel").runs
        cancelled.set()
        assert sum(claimer.result() for claimer in claimers) == 0
    assert left.queued == 0
    assert left.cancelled + left.running == 2000
    assert counts(store, sweep.id) == left


def test_a_sweep_whose_runs_are_all_paused_is_paused(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    for ordinal in range(2):
        store.move_run(f"{sweep.id}-{ordinal}", "pause")
    found = store.find_sweep(sweep.id)
    assert found is not None
    assert found.status is SweepStatus.PAUSED
    assert store.move_sweep(sweep.id, "resume").runs == RunCounts(queued=2)


def test_a_failed_run_is_tried_again_with_a_clean_slate(store: Store, submit: Submit) -> None:
    """It was given up after too many losses; the next loss is its first again."""
    run_id = f"{submit(seeds=1).id}-0"
    for _ in range(AT_ONCE.losses + 1):
        claim = store.claim_cohort("w", LEASE)
        assert claim is not None
        store.lose(claim, "its worker was lost")
    for _ in range(2):
        run = store.move_run(run_id, "retry")
        assert (run.status, run.attempt) == (RunStatus.QUEUED, AT_ONCE.losses + 1)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.lose(claim, "its worker was lost")
    again = store.find_run(run_id)
    assert again is not None
    assert again.status is RunStatus.QUEUED
    assert len(store.attempts(run_id)) == AT_ONCE.losses + 2


def test_the_time_between_attempts_is_no_work(store: Store, submit: Submit) -> None:
    """A run that is tried again later has taken as long as its attempts, not as the wait."""
    run_id = f"{submit(seeds=1).id}-0"
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    run = store.find_run(run_id)
    assert run is not None
    assert run.worked_seconds is None
    store.fail(claim, "ValueError: no")
    time.sleep(0.3)  # the wait that must not count
    store.move_run(run_id, "retry")
    again = store.claim_cohort("w", LEASE)
    assert again is not None
    store.record(again, Progress(1600, finished=(0,)))
    run = store.find_run(run_id)
    assert run is not None
    assert run.worked_seconds is not None
    assert run.started_at is not None
    assert run.finished_at is not None
    assert 0 <= run.worked_seconds <= run.finished_at - run.started_at - 0.3
