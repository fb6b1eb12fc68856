"""Checkpoints as the store knows them: where a run goes on, and what becomes of its points."""

from service.model.claim import Claim
from service.model.run import RunStatus
from service.store.store import Store
from tests.service.store.conftest import Submit, measured
from workers.messages.progress import Activity, CheckpointAttempt, Progress, Resumption

LEASE = 60.0
FINGERPRINT = {"code": "abc", "processor": "AVX512"}


def claim_of(store: Store) -> Claim:
    claim = store.claim_cohort("worker-1", LEASE)
    assert claim is not None
    return claim


def begin(store: Store, claim: Claim, *resumed: Resumption, **fingerprint: str) -> None:
    store.record(
        claim,
        Progress(
            0,
            Activity.COMPILING,
            resumed=resumed,
            fingerprint=FINGERPRINT | fingerprint,
            measurements=tuple(
                measured(r.seed, step) for r in resumed for step in range(800, r.timestep + 1, 800)
            ),
        ),
    )


def train(store: Store, claim: Claim, timestep: int, checkpoint: int | None = None) -> None:
    """Measure all seeds there; a checkpoint was written at another timestep."""
    seeds = [run.spec.seed for run in claim.runs]
    written = [] if checkpoint is None else [CheckpointAttempt(seed, checkpoint) for seed in seeds]
    store.record(
        claim,
        Progress(
            timestep,
            measurements=tuple(measured(seed, timestep) for seed in seeds),
            checkpoints=tuple(written),
        ),
    )


def steps(store: Store, run_id: str) -> list[int]:
    return [m.timestep for m in store.measurements(run_id)]


def test_a_lost_run_goes_on_at_its_checkpoint(store: Store, submit: Submit) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    first = claim_of(store)
    begin(store, first, Resumption(0, 0))
    train(store, first, 800)
    train(store, first, 1600, checkpoint=1000)
    run = store.find_run(run_id)
    assert run is not None
    assert (run.timestep, run.resumed_timestep, run.checkpoint_timestep) == (1600, 0, 1000)
    store.lose(first, "its worker was lost")

    second = claim_of(store)
    run = store.find_run(run_id)
    assert run is not None
    assert (run.timestep, run.resumed_timestep) == (1000, None)
    begin(store, second, Resumption(0, 1000))
    run = store.find_run(run_id)
    assert run is not None
    assert (run.attempt, run.timestep, run.resumed_timestep) == (2, 1000, 1000)
    assert steps(store, run_id) == [800, 1600]  # the same bits as those to come
    assert [a.resumed_timestep for a in store.attempts(run_id)] == [0, 1000]


def test_what_compiles_has_come_no_further_than_its_checkpoint(
    store: Store, submit: Submit
) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    first = claim_of(store)
    train(store, first, 800, checkpoint=800)
    store.lose(first, "its worker was lost")
    second = claim_of(store)
    store.record(second, Progress(0, Activity.COMPILING))
    run = store.find_run(run_id)
    assert run is not None
    assert run.timestep == 800


def test_points_that_were_never_delivered_come_with_the_checkpoint(
    store: Store, submit: Submit
) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    begin(store, claim_of(store), Resumption(0, 2400))
    assert steps(store, run_id) == [800, 1600, 2400]


def test_another_machines_points_go_but_those_of_the_checkpoint(
    store: Store, submit: Submit
) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    first = claim_of(store)
    begin(store, first, Resumption(0, 0))
    for timestep in (800, 1600, 2400):
        train(store, first, timestep, checkpoint=1600)
    store.lose(first, "its worker was lost")
    mark = "processor was AVX512, now AVX2"
    second = claim_of(store)
    begin(store, second, Resumption(0, 1600, (mark,), f"not bit-comparable: {mark}"), processor="b")
    run = store.find_run(run_id)
    assert run is not None
    assert steps(store, run_id) == [800, 1600]
    assert run.fingerprint == {**FINGERPRINT, "processor": "b", "mixed_with": [mark]}
    assert run.reason == f"not bit-comparable: {mark}"
    assert store.attempts(run_id)[1].note == run.reason


def test_a_cohort_was_left_at_one_timestep(store: Store, submit: Submit) -> None:
    submit(seeds=4)
    first = claim_of(store)
    seeds = [run.spec.seed for run in first.runs]
    written = tuple(CheckpointAttempt(seed, 800) for seed in seeds[2:])
    store.record(first, Progress(900, checkpoints=written))
    store.release(first, "stopped")
    assert [run.spec.seed for run in claim_of(store).runs] == seeds[:2]
    assert [run.spec.seed for run in claim_of(store).runs] == seeds[2:]


def test_those_that_wait_for_their_group_have_come_no_further(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    claim = claim_of(store)
    begin(store, claim, Resumption(0, 800), Resumption(1, 0))
    store.move_run(f"{sweep.id}-1", "cancel")
    store.record(claim, Progress(1600, training=(0,), dropped=(1,)))
    front, waiting = store.list_runs(sweep.id)
    assert (front.timestep, waiting.timestep) == (1600, 0)
    assert waiting.status is RunStatus.CANCELLED


def test_a_checkpoint_that_could_not_be_written_is_the_reason_until_one_is(
    store: Store, submit: Submit
) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    claim = claim_of(store)
    before = store.last_event_id()
    problem = "its checkpoint of step 800 could not be written: No space left on device"
    store.record(claim, Progress(800, checkpoints=(CheckpointAttempt(0, 800, problem),)))
    run = store.find_run(run_id)
    assert run is not None
    assert (run.reason, run.checkpoint_timestep) == (problem, 0)
    assert [event.payload["reason"] for event in store.events_after(before)] == [problem]
    store.record(claim, Progress(1000, checkpoints=(CheckpointAttempt(0, 1000),)))
    run = store.find_run(run_id)
    assert run is not None
    assert (run.reason, run.checkpoint_timestep) == ("", 1000)


def test_what_is_said_of_where_a_run_was_taken_up_stays_until_it_ends(
    store: Store, submit: Submit
) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    first = claim_of(store)
    train(store, first, 800, checkpoint=800)
    store.lose(first, "its worker was lost")
    second = claim_of(store)
    damaged = "newest checkpoint damaged (hash mismatch), resumed from step 400"
    begin(store, second, Resumption(0, 400, note=damaged))
    problem = "its checkpoint of step 1600 could not be written: No space left on device"

    def reason_after(*written: CheckpointAttempt) -> str:
        store.record(second, Progress(1600, checkpoints=written))
        run = store.find_run(run_id)
        assert run is not None
        return run.reason

    assert reason_after(CheckpointAttempt(0, 1000)) == damaged
    assert reason_after(CheckpointAttempt(0, 1600, problem)) == f"{damaged}, {problem}"
    assert reason_after() == f"{damaged}, {problem}"
    before = store.last_event_id()
    assert reason_after(CheckpointAttempt(0, 1700)) == damaged
    assert reason_after(CheckpointAttempt(0, 1800)) == damaged
    assert [event.payload["reason"] for event in store.events_after(before)] == [damaged]


def test_files_that_nobody_told_of_are_to_be_removed_too(store: Store, submit: Submit) -> None:
    """Its worker is lost between writing a checkpoint and telling of it."""
    run_id = f"{submit(seeds=1).id}-0"
    store.move_run(f"{submit(seeds=1).id}-0", "cancel")  # no worker had it: it has no files
    claim = claim_of(store)
    store.lose(claim, "its worker was lost")
    assert [*store.ended_with_checkpoints(10)] == []
    store.move_run(run_id, "cancel")
    assert [*store.ended_with_checkpoints(10)] == [run_id]
    store.forget_checkpoints([run_id])
    assert [*store.ended_with_checkpoints(10)] == []


def test_a_refused_checkpoints_files_are_to_be_removed_when_the_run_has_ended(
    store: Store, submit: Submit
) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    first = claim_of(store)
    train(store, first, 800, checkpoint=800)
    store.lose(first, "its worker was lost")
    second = claim_of(store)
    begin(store, second, Resumption(0, 0, note="its checkpoint was made by other code"))
    store.fail(second, "ValueError: x")
    assert [*store.ended_with_checkpoints(10)] == [run_id]


def test_a_run_that_is_tried_again_meanwhile_keeps_what_it_has(
    store: Store, submit: Submit
) -> None:
    run_id = f"{submit(seeds=1).id}-0"
    store.fail(claim_of(store), "ValueError: x")
    assert [*store.ended_with_checkpoints(10)] == [run_id]
    store.move_run(run_id, "retry")
    again = claim_of(store)
    store.forget_checkpoints([run_id])
    store.fail(again, "ValueError: x")
    assert [*store.ended_with_checkpoints(10)] == [run_id]


def test_checkpoints_of_ended_runs_are_to_be_removed_once(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3)
    claim = claim_of(store)
    train(store, claim, 800, checkpoint=800)
    assert [*store.ended_with_checkpoints(10)] == []
    store.record(claim, Progress(800, finished=(0,)))
    store.fail(claim, "ValueError: x")
    ended = sorted(store.ended_with_checkpoints(10))
    assert ended == [f"{sweep.id}-{ordinal}" for ordinal in range(3)]
    store.forget_checkpoints(ended[:2])
    assert [*store.ended_with_checkpoints(10)] == ended[2:]
