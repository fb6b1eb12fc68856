"""Sweeps and runs: creating, reading, paging, cancelling."""

from itertools import pairwise

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from service.model.claim import Claim
from service.model.run import RunStatus
from service.model.sweep import RunCounts, SweepStatus
from service.store.refusal import ImpossibleMoveError, NotFoundError
from service.store.store import Store
from tests.service.promises import runs_of
from tests.service.store.conftest import Submit, measured
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec, Weights

LEASE = 60.0


def test_a_sweep_becomes_its_runs_in_order(store: Store) -> None:
    specs = [
        RunSpec("hybrid-ddpg", environment, seed, Weights(0.1, w2), 4000, {"batch": 64})
        for environment in ("Pendulum", "MassPoint")
        for w2 in (0.0, 0.01)
        for seed in (7, 3)
    ]
    versions = {"Pendulum": 2, "MassPoint": 1}
    request = {"name": "x", "seeds": [7, 3]}
    sweep = store.create_sweep("x", 5, request, specs, environment_versions=versions)
    assert store.find_sweep(sweep.id) == sweep
    assert (sweep.priority, sweep.request, sweep.runs) == (5, request, RunCounts(queued=8))
    assert (sweep.status, sweep.progress, sweep.eta_seconds) == (SweepStatus.QUEUED, 0.0, None)
    runs = store.list_runs(sweep.id)
    assert [run.spec for run in runs] == specs
    assert [run.id for run in runs] == [f"{sweep.id}-{ordinal}" for ordinal in range(8)]
    assert [run.environment_version for run in runs] == [2] * 4 + [1] * 4
    assert store.find_run(runs[5].id) == runs[5]


def test_a_sweep_has_runs(store: Store) -> None:
    with pytest.raises(ValueError, match="at least one run"):
        store.create_sweep("empty", 0, {}, [], environment_versions={})
    assert store.list_sweeps() == []


def test_half_a_sweep_is_never_there(store: Store) -> None:
    unversioned = [RunSpec("ddpg", "Pendulum", 0), RunSpec("ddpg", "MassPoint", 0)]
    with pytest.raises(KeyError):
        store.create_sweep("x", 0, {}, unversioned, environment_versions={"Pendulum": 1})
    assert store.list_sweeps() == []
    assert store.events_after(0) == []


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=20, deadline=None
)
@given(name=st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0")))
def test_names_are_stored_exactly(store: Store, name: str) -> None:
    request = {"name": name}
    specs = [RunSpec("ddpg", "Pendulum", 0, config={name: name})]
    sweep = store.create_sweep(name, 0, request, specs, environment_versions={"Pendulum": 1})
    found = store.find_sweep(sweep.id)
    assert found is not None
    assert (found.name, found.request) == (name, request)
    assert store.list_runs(sweep.id)[0].spec == specs[0]


@pytest.mark.parametrize(
    "name", ["", "x", "{id}", "{id}-", "{id}-4", "{id}-00", "{id}-0 ", "{id}-1e0", "{id}-²", "-0"]
)
def test_what_is_no_run_is_not_found(store: Store, submit: Submit, name: str) -> None:
    run_id = name.replace("{id}", submit(seeds=4).id)
    assert store.find_run(run_id) is None
    assert store.measurements(run_id) == []
    with pytest.raises(NotFoundError):
        store.move_run(run_id, "cancel")


def test_sweeps_are_paged_newest_first(store: Store, submit: Submit) -> None:
    ids = [submit(seeds=1).id for _ in range(5)][::-1]
    first = store.list_sweeps(limit=2)
    rest = store.list_sweeps(after=first[-1].id, limit=9)
    assert [sweep.id for sweep in first + rest] == ids
    assert store.list_sweeps(after="no sweep") == []


def test_runs_are_paged_and_filtered(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3, environments=("Pendulum", "MassPoint"))
    pages = [store.list_runs(sweep.id, after=after, limit=4) for after in (None, f"{sweep.id}-3")]
    assert [len(page) for page in pages] == [4, 2]
    assert len(store.list_runs(sweep.id, environment="MassPoint", after=f"{sweep.id}-3")) == 2
    assert store.list_runs(sweep.id, algorithm="sac") == []
    claim = store.claim_cohort("w", LEASE, 2)
    assert claim is not None
    running = store.list_runs(sweep.id, status=RunStatus.RUNNING)
    assert [run.id for run in running] == [run.run_id for run in claim.runs]


def test_counts_progress_and_pace(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=4, timesteps=1600)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.record(claim, Progress(400))
    halfway = store.find_sweep(sweep.id)
    assert halfway is not None
    assert (halfway.progress, halfway.status) == (0.25, SweepStatus.RUNNING)
    assert halfway.eta_seconds is not None
    assert 0 <= halfway.eta_seconds < 60
    store.record(claim, Progress(1600, finished=(0, 1)))
    store.fail(claim.only({f"{sweep.id}-2"}), "ValueError: no")
    store.record(claim, Progress(1600, finished=(3,)))
    ended = store.find_sweep(sweep.id)
    assert ended is not None
    assert ended.runs == RunCounts(succeeded=3, failed=1)
    assert (ended.progress, ended.eta_seconds) == (1.0, 0.0)
    assert ended.status is SweepStatus.FINISHED


def test_progress_is_of_what_was_trained(store: Store, submit: Submit) -> None:
    """A run that was cancelled or failed has done what it did, and has nothing left to do."""
    sweep = submit(seeds=4, timesteps=1600)
    store.move_run(f"{sweep.id}-3", "cancel")
    cancelled = store.find_sweep(sweep.id)
    assert cancelled is not None
    assert cancelled.progress == 0.0
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.record(claim, Progress(800))
    store.fail(claim.only({f"{sweep.id}-0"}), "ValueError: no")
    halfway = store.find_sweep(sweep.id)
    assert halfway is not None
    assert halfway.progress == 3 * 800 / (4 * 1600)
    store.record(claim, Progress(1600, finished=(1, 2)))
    ended = store.find_sweep(sweep.id)
    assert ended is not None
    assert (ended.progress, ended.eta_seconds) == ((800 + 2 * 1600) / (4 * 1600), 0.0)


def test_a_sweep_without_a_finished_run_is_not_done(store: Store, submit: Submit) -> None:
    def cancel(sweep_id: str) -> None:
        store.move_sweep(sweep_id, "cancel")

    for end in (cancel, lambda _: store.fail(claimed(store), "ValueError: no")):
        sweep = submit()
        end(sweep.id)
        ended = store.find_sweep(sweep.id)
        assert ended is not None
        assert (ended.runs.active, ended.progress) == (0, 0.0)


def claimed(store: Store) -> Claim:
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    return claim


def test_what_was_posted_is_read_alone(store: Store) -> None:
    request = {"name": "é", "seeds": 1}
    specs = [RunSpec("ddpg", "Pendulum", 0)]
    sweep = store.create_sweep("x", 0, request, specs, environment_versions={"Pendulum": 1})
    assert store.sweep_request(sweep.id) == request
    with pytest.raises(NotFoundError, match="no sweep"):
        store.sweep_request("0123456789ab")


def test_cancelling_a_sweep_ends_what_waits_and_tells_what_runs(
    store: Store, submit: Submit
) -> None:
    sweep = submit(seeds=4)
    claim = store.claim_cohort("w", LEASE, 2)
    assert claim is not None
    cancelled = store.move_sweep(sweep.id, "cancel")
    assert cancelled.runs == RunCounts(running=2, cancelled=2)
    assert store.cancelling_runs() == {run.run_id for run in claim.runs}
    assert store.move_sweep(sweep.id, "cancel").runs == cancelled.runs  # again: no error, no change
    assert store.claim_cohort("w", LEASE) is None
    store.record(claim, Progress(800, dropped=(0, 1)))
    ended = store.find_sweep(sweep.id)
    assert ended is not None
    assert (ended.status, ended.runs) == (SweepStatus.CANCELLED, RunCounts(cancelled=4))
    assert store.move_sweep(sweep.id, "cancel") == ended
    assert store.cancelling_runs() == set()


def test_a_finished_sweep_cannot_be_cancelled(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.record(claim, Progress(1600, finished=(0,)))
    with pytest.raises(ImpossibleMoveError, match="has finished"):
        store.move_sweep(sweep.id, "cancel")
    with pytest.raises(ImpossibleMoveError, match="already succeeded"):
        store.move_run(f"{sweep.id}-0", "cancel")
    with pytest.raises(NotFoundError, match="no sweep 'x'"):
        store.move_sweep("x", "cancel")


def test_cancelling_one_run_leaves_its_neighbours(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3)
    assert store.move_run(f"{sweep.id}-2", "cancel").status is RunStatus.CANCELLED
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    assert [run.spec.seed for run in claim.runs] == [0, 1]
    run = store.move_run(f"{sweep.id}-0", "cancel")
    assert (run.status, run.is_cancelling) == (RunStatus.RUNNING, True)
    assert store.move_run(f"{sweep.id}-0", "cancel") == run
    store.record(claim, Progress(1600, dropped=(0,), finished=(1,)))
    ended = store.find_sweep(sweep.id)
    assert ended is not None
    assert ended.runs == RunCounts(succeeded=1, cancelled=2)
    assert ended.status is SweepStatus.FINISHED  # some runs were cancelled, the sweep was not


def test_a_run_that_finishes_before_it_is_told_has_succeeded(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.move_sweep(sweep.id, "cancel")
    store.record(claim, Progress(1600, measurements=(measured(0, 1600),), finished=(0,)))
    run = store.find_run(f"{sweep.id}-0")
    assert run is not None
    assert (run.status, run.is_cancelling) == (RunStatus.SUCCEEDED, False)


def test_every_change_has_its_event(store: Store, submit: Submit) -> None:
    sweep, other = submit(seeds=2), submit(seeds=1)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.record(claim, Progress(800, measurements=(measured(0, 400), measured(0, 800))))
    store.record(claim, Progress(1600, finished=(0,)))
    store.move_run(f"{sweep.id}-1", "cancel")
    store.record(claim, Progress(1600, dropped=(1,)))
    events = store.events_after(0, sweep.id)
    said = [
        (event.kind, "".join(runs_of(event)) or None, event.payload.get("status"))
        for event in events
    ]
    assert said == [
        ("sweep", None, None),
        ("run", f"{sweep.id}-0", "running"),
        ("run", f"{sweep.id}-1", "running"),
        ("measurements", f"{sweep.id}-0", None),
        ("run", f"{sweep.id}-0", "succeeded"),
        ("run", f"{sweep.id}-1", "cancelled"),
    ]
    assert events[3].payload == {
        "sweep_id": sweep.id,
        "run_ids": [f"{sweep.id}-0"],
        "from": 400,
        "to": 800,
    }
    assert all(earlier.id < later.id for earlier, later in pairwise(events))
    assert store.last_event_id() == events[-1].id
    assert {event.sweep_id for event in store.events_after(0)} == {sweep.id, other.id}
    assert store.events_after(events[2].id, sweep.id, limit=2) == events[3:5]
