"""Claims: who is next, and what a claim protects."""

from collections.abc import Callable
from functools import partial

from sqlalchemy import event

from service.model.claim import Claim
from service.model.run import RunStatus
from service.model.sweep import RunCounts
from service.store.claiming.turns import ALONE_AFTER
from service.store.store import Store
from tests.service.promises import runs_of
from tests.service.store.conftest import AT_ONCE, Submit, measured
from workers.messages.progress import Progress, Resumption
from workers.messages.run_spec import COHORT_LIMIT, RunSpec, Weights

LEASE = 60.0
OVER = -1.0  # a lease that has ended as it begins


def claim_of(store: Store, limit: int = COHORT_LIMIT, lease_seconds: float = LEASE) -> Claim:
    claim = store.claim_cohort("worker-1", lease_seconds, limit)
    assert claim is not None
    return claim


def sweep_of(claim: Claim) -> str:
    return claim.runs[0].run_id.partition("-")[0]


def test_nothing_waits(store: Store) -> None:
    assert store.claim_cohort("w", LEASE) is None
    assert store.waiting_cells(limit=100) == []


def test_a_cohort_is_of_one_cell(store: Store, submit: Submit) -> None:
    submit(seeds=3, environments=("Pendulum", "MassPoint"))
    first, second = claim_of(store), claim_of(store)
    assert [run.spec.environment for run in first.runs] == ["Pendulum"] * 3
    assert [run.spec.seed for run in second.runs] == [0, 1, 2]
    assert {run.spec.environment for run in second.runs} == {"MassPoint"}
    assert store.claim_cohort("w", LEASE) is None


def test_a_cohort_differs_in_the_seed_alone(store: Store) -> None:
    specs = [
        RunSpec("ddpg", "Pendulum", seed, weights, timesteps, config)
        for seed in (0, 1)
        for weights in (Weights(), Weights(0.1))
        for timesteps in (800, 1600)
        for config in ({}, {"batch": 32})
    ]
    store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
    for _ in range(8):
        claim = claim_of(store)
        assert len({run.spec.cell for run in claim.runs}) == 1
        assert [run.spec.seed for run in claim.runs] == [0, 1]


def test_a_cohort_has_at_most_sixteen_runs(store: Store, submit: Submit) -> None:
    submit(seeds=20)
    assert [len(claim_of(store, 99).runs), len(claim_of(store).runs)] == [16, 4]


def test_a_cohort_is_within_its_cells_limit(store: Store, submit: Submit) -> None:
    submit(seeds=5, environments=("Pendulum", "MassPoint"))
    limits = {"Pendulum": 2, "MassPoint": 4}
    sizes: list[tuple[str, int]] = []
    while claim := store.claim_cohort(
        "worker-1", LEASE, limit_of=lambda cell: limits[cell.environment]
    ):
        sizes.append((claim.runs[0].spec.environment, len(claim.runs)))
    assert sizes == [
        *(("Pendulum", 2), ("Pendulum", 2), ("Pendulum", 1)),
        *(("MassPoint", 4), ("MassPoint", 1)),
    ]


def test_higher_priority_goes_first(store: Store, submit: Submit) -> None:
    submit(seeds=2, priority=0)
    urgent = submit(seeds=2, priority=1)
    assert sweep_of(claim_of(store)) == urgent.id


def test_equal_sweeps_take_turns(store: Store, submit: Submit) -> None:
    large, small = submit(seeds=64), submit(seeds=4)
    assert [sweep_of(claim_of(store, 2)) for _ in range(4)] == [
        large.id,
        small.id,
        large.id,
        small.id,
    ]


def test_a_large_sweep_does_not_starve_a_small_one_on_a_single_worker(
    store: Store, submit: Submit
) -> None:
    large, small = submit(seeds=64), submit(seeds=4)
    served = []
    for _ in range(2):
        claim = claim_of(store)
        served.append(sweep_of(claim))
        seeds = tuple(run.spec.seed for run in claim.runs)
        store.record(claim, Progress(1600, finished=seeds))
    assert served == [large.id, small.id]


def test_ten_thousand_runs_do_not_starve_ten(store: Store, submit: Submit) -> None:
    """Two workers that are never idle: the small sweep has every second cohort until it is done."""
    large = submit(seeds=10_000)
    busy = [claim_of(store), claim_of(store)]
    small = submit(seeds=64)
    served = []
    for turn in range(8):
        ended = busy.pop(0)
        store.record(ended, Progress(1600, finished=tuple(run.spec.seed for run in ended.runs)))
        busy.append(claim_of(store))
        served.append(sweep_of(busy[-1]))
        assert turn > 0 or served == [small.id]
    assert served.count(small.id) == 4
    assert served[-1] == large.id


def test_a_claim_opens_an_attempt(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1)
    claim = claim_of(store)
    run = store.find_run(f"{sweep.id}-0")
    assert run is not None
    assert (run.status, run.attempt, run.started_at is None) == (RunStatus.RUNNING, 1, False)
    assert claim.runs[0].attempt == 1
    [attempt] = store.attempts(run.id)
    assert (attempt.worker, attempt.outcome, attempt.ended_at) == ("worker-1", "running", None)


def test_a_lease_that_ended_puts_its_runs_back(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    lost = claim_of(store, lease_seconds=OVER)
    assert store.lose_expired() == 2
    assert store.lose_expired() == 0
    again = claim_of(store)
    assert [run.attempt for run in again.runs] == [2, 2]
    # The first worker wakes up: nothing that it says is taken.
    late = Progress(1600, measurements=(measured(0, 800),), finished=(0, 1))
    assert store.record(lost, late) == set()
    store.fail(lost, "ValueError: late")
    store.release(lost, "late")
    assert store.measurements(f"{sweep.id}-0") == []
    found = store.find_sweep(sweep.id)
    assert found is not None
    assert found.runs == RunCounts(running=2)


def test_news_renew_the_lease(store: Store, submit: Submit) -> None:
    submit(seeds=1)
    claim = claim_of(store, lease_seconds=OVER)
    renewing = Claim(claim.worker, LEASE, claim.runs)
    assert store.record(renewing, Progress(0)) == {claim.runs[0].run_id}
    assert store.lose_expired() == 0


def test_a_lost_worker_is_noted_with_its_last_words(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1)
    store.lose(claim_of(store), "its worker was lost: SIGKILL", "Segmentation fault")
    run = store.find_run(f"{sweep.id}-0")
    assert run is not None
    assert (run.status, run.reason) == (RunStatus.QUEUED, "its worker was lost: SIGKILL")
    [attempt] = store.attempts(run.id)
    assert (attempt.outcome, attempt.log_tail) == ("lost", "Segmentation fault")
    assert attempt.ended_at is not None


def test_losses_in_a_row_are_bounded(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1)
    for _ in range(AT_ONCE.losses + 1):
        store.lose(claim_of(store), "its worker was lost")
    run = store.find_run(f"{sweep.id}-0")
    assert run is not None
    assert run.status is RunStatus.FAILED
    assert run.reason.startswith("given up after losing 4 workers in a row")
    assert [attempt.outcome for attempt in store.attempts(run.id)] == ["lost"] * 3 + ["failed"]


def test_new_measurements_end_the_row_of_losses(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1, timesteps=80_000)
    for step in range(1, 2 * AT_ONCE.losses):
        claim = claim_of(store)
        replayed = tuple(measured(0, 800 * i) for i in range(1, step + 1))
        store.record(claim, Progress(800 * step, measurements=replayed))
        store.lose(claim, "its worker was lost")
    run = store.find_run(f"{sweep.id}-0")
    assert run is not None
    assert run.status is RunStatus.QUEUED


def test_replayed_measurements_do_not(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1)
    for _ in range(AT_ONCE.losses + 2):
        if (claim := store.claim_cohort("w", LEASE)) is None:
            break
        store.record(claim, Progress(800, measurements=(measured(0, 800),)))
        store.lose(claim, "its worker was lost")
    run = store.find_run(f"{sweep.id}-0")
    assert run is not None
    assert run.status is RunStatus.FAILED


def test_a_release_is_no_loss(store: Store, submit: Submit) -> None:
    submit(seeds=1)
    for attempt in range(1, 3 * AT_ONCE.losses):
        claim = claim_of(store)
        assert claim.runs[0].attempt == attempt
        store.release(claim, "the service was stopped")


def test_a_run_that_keeps_losing_workers_trains_alone(store: Store, submit: Submit) -> None:
    submit(seeds=3)
    for _ in range(ALONE_AFTER):
        claim = claim_of(store)
        assert len(claim.runs) == 3
        store.lose(claim, "its worker was lost")
    assert [len(claim_of(store).runs) for _ in range(3)] == [1, 1, 1]


def test_a_loss_is_waited_for(url: str) -> None:
    patient = Store.open(url)
    specs = [RunSpec("ddpg", "Pendulum", 0)]
    patient.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
    patient.lose(claim_of(patient), "its worker was lost")
    assert patient.waiting_cells(limit=100) == []
    assert patient.claim_cohort("w", LEASE) is None
    patient.close()


def test_lost_runs_that_were_to_be_cancelled_are_cancelled(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3)
    claim = claim_of(store)
    store.move_run(f"{sweep.id}-0", "cancel")
    store.lose(claim, "its worker was lost")
    found = store.find_sweep(sweep.id)
    assert found is not None
    assert found.runs == RunCounts(queued=2, cancelled=1)


def test_an_error_in_code_fails_at_once_and_keeps_its_traceback(
    store: Store, submit: Submit
) -> None:
    sweep = submit(seeds=2)
    traceback = "Traceback (most recent call last):\n  ...\nValueError: no such layer\n"
    store.fail(claim_of(store), traceback, "some output")
    run = store.find_run(f"{sweep.id}-1")
    assert run is not None
    assert (run.status, run.reason) == (RunStatus.FAILED, "ValueError: no such layer")
    [attempt] = store.attempts(run.id)
    assert (attempt.error, attempt.log_tail) == (traceback, "some output")
    assert store.claim_cohort("w", LEASE) is None


def test_whatever_a_worker_prints_is_kept(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    claim = claim_of(store)
    store.lose(claim.only({f"{sweep.id}-0"}), "exit \0", "\ud800 torn")
    store.fail(claim.only({f"{sweep.id}-1"}), "ValueError: \0\udfff", "a\0b")
    assert [a.log_tail for a in store.attempts(f"{sweep.id}-0")] == [r"\ud800 torn"]
    [attempt] = store.attempts(f"{sweep.id}-1")
    assert (attempt.error, attempt.log_tail) == (r"ValueError: \x00\udfff", r"a\x00b")
    run = store.find_run(f"{sweep.id}-1")
    assert run is not None
    assert run.reason == attempt.error


def test_what_many_workers_said_is_written_at_once(store: Store, submit: Submit) -> None:
    submit(seeds=2, environments=("Pendulum", "MassPoint"), timesteps=1600)
    claims = [claim_of(store), claim_of(store)]
    said = [
        (claim, Progress(800 * reached, measurements=(measured(0, 800 * reached),), finished=ended))
        for claim, reached, ended in zip(claims, (1, 2), ((), (0, 1)), strict=True)
    ]
    going_on = {run.run_id for run in claims[0].runs}
    assert store.record_all(said) == [going_on, set()]
    assert store.record_all(said) == [going_on, set()]  # its answer was lost
    first, second = (claim.runs[0].run_id for claim in claims)
    assert store.measurements(first) == [measured(0, 800)]
    assert store.measurements(second) == [measured(0, 1600)]
    told = [event for event in store.events_after(0) if second in runs_of(event)]
    assert [event.payload.get("status", "measured") for event in told] == [
        RunStatus.RUNNING,
        "measured",
        RunStatus.SUCCEEDED,
    ]
    assert store.record_all([]) == []


def test_a_claim_that_was_given_up_spoils_none_of_the_others(store: Store, submit: Submit) -> None:
    submit(seeds=2, environments=("Pendulum", "MassPoint"))
    given_up, other = claim_of(store), claim_of(store)
    store.release(given_up, "x")
    current = claim_of(store)
    assert {run.run_id for run in current.runs} == {run.run_id for run in given_up.runs}
    point = measured(0, 800)
    late = (given_up, Progress(800, measurements=(point,), finished=(0,)))
    held = store.record_all([late, (other, Progress(800, measurements=(point,)))])
    assert held == [set(), {run.run_id for run in other.runs}]
    assert store.measurements(current.runs[0].run_id) == []
    assert store.measurements(other.runs[0].run_id) == [point]


def statements(store: Store, work: Callable[[], object]) -> int:
    """How many the writer sends while the work is done."""
    sent: list[str] = []

    def note(*told: object) -> None:
        sent.append(str(told[2]))

    event.listen(store._writer_engine, "before_cursor_execute", note)
    work()
    event.remove(store._writer_engine, "before_cursor_execute", note)
    return len(sent)


def test_many_workers_are_served_by_as_many_statements_as_two(store: Store, submit: Submit) -> None:
    submit(seeds=64, environments=("Pendulum", "MassPoint"))
    claims: dict[int, list[Claim]] = {}

    def claim(workers: int) -> None:
        asked = [(f"worker-{number}", 4) for number in range(workers)]
        claims[workers] = [each for each in store.claim_all(asked, LEASE) if each is not None]

    def report(workers: int, timestep: int, *, is_over: bool = False) -> None:
        said = []
        for claim in claims[workers]:
            seeds = tuple(run.spec.seed for run in claim.runs)
            points = tuple(measured(seed, timestep) for seed in seeds)
            resumed = () if is_over else tuple(Resumption(seed, 0) for seed in seeds)
            said.append(
                (
                    claim,
                    Progress(
                        timestep,
                        measurements=points,
                        finished=seeds if is_over else (),
                        resumed=resumed,
                        fingerprint={"cpu": "x"} if resumed else {},
                    ),
                )
            )
        store.record_all(said)

    claim(1)
    report(1, 800)  # the diagnostics' names are written once
    for work in (
        claim,
        partial(report, timestep=800),
        partial(report, timestep=1600, is_over=True),
    ):
        assert statements(store, partial(work, 2)) == statements(store, partial(work, 8))
    assert [len(each) for each in claims.values()] == [1, 2, 8]


def test_no_more_runs_that_wait_are_counted_than_asked(store: Store, submit: Submit) -> None:
    submit(seeds=5)
    assert [store.waiting_cells(limit) for limit in (1, 5, 100)] == [[1], [5], [5]]


def test_what_waits_is_counted_by_what_could_be_claimed_together(
    store: Store, submit: Submit
) -> None:
    submit(seeds=5, environments=("Pendulum", "MassPoint"))
    submit(seeds=2)
    assert sorted(store.waiting_cells(limit=100)) == [2, 5, 5]
    for _ in range(ALONE_AFTER):
        store.lose(claim_of(store, limit=3), "its worker was lost")
    counted = sorted(store.waiting_cells(limit=100))
    assert sum(counted) == 12
    sizes = []
    while (claim := store.claim_cohort("w", LEASE)) is not None:
        sizes.append(len(claim.runs))
    assert counted == sorted(sizes)
