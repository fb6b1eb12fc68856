"""Batches of a question: written once, of what was seen, on every database."""

from typing import Any

import pytest

from algorithms.early_end import Failure
from service.model.run import RunStatus
from service.model.sweep import Sweep, SweepStatus
from service.store.store import Store
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec, Weights

QUESTION: dict[str, Any] = {"question": {"compare": ["hybrid-ddpg"], "with": "ddpg"}}
BATCH = {("Pendulum", 0): (4, 0, 5), ("Pendulum", 1): (4, 0, 5)}


@pytest.fixture
def sweep(store: Store) -> Sweep:
    """One whose two runs, of seed 4, have ended."""
    specs = [
        RunSpec("ddpg", "Pendulum", 4, timesteps=1600),
        RunSpec("hybrid-ddpg", "Pendulum", 4, Weights(0.1, 0.2), 1600, {"noise": 0.3}),
    ]
    sweep = store.create_sweep(
        "x", 0, QUESTION, specs, entries=[0, 1], environment_versions={"Pendulum": 7}
    )
    assert sweep.is_asking
    assert store.waiting_questions() == []
    end_all(store)
    return sweep


def end_all(store: Store) -> None:
    while claim := store.claim_cohort("w", 60.0):
        store.record(claim, Progress(1600, finished=tuple(spec.seed for spec in claim.specs)))


def test_a_batch_is_of_its_cells_and_once(store: Store, sweep: Sweep) -> None:
    assert store.waiting_questions() == [sweep.id]
    seen = store.sweep_version(sweep.id)
    assert store.go_on_asking(sweep.id, seen, BATCH) == 4
    for _ in range(2):
        assert store.go_on_asking(sweep.id, seen, BATCH) == 0
    runs = store.list_runs(sweep.id)
    assert [(run.id.partition("-")[2], run.entry, run.spec.seed) for run in runs] == [
        ("0", 0, 4), ("1", 1, 4), ("2", 0, 0), ("3", 0, 5), ("4", 1, 0), ("5", 1, 5),
    ]  # fmt: skip
    new = runs[-1]
    assert new.spec == RunSpec(
        "hybrid-ddpg", "Pendulum", 5, Weights(0.1, 0.2), 1600, {"noise": 0.3}
    )
    assert (new.environment_version, new.status, new.attempt) == (7, RunStatus.QUEUED, 0)
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    assert [spec.seed for spec in claim.specs] == [0, 5]  # the runs of a cell train together
    assert store.waiting_questions() == []
    changes = [each.payload["change"] for each in store.events_after(0) if each.kind == "sweep"]
    assert changes == ["created", "extended"]


def test_a_batch_that_is_all_there_settles_the_question(store: Store, sweep: Sweep) -> None:
    seen = store.sweep_version(sweep.id)
    assert store.go_on_asking(sweep.id, seen, {("Pendulum", 0): (4,)}) == 0
    assert store.events_after(0)[-1].payload == {"sweep_id": sweep.id, "change": "answered"}
    assert store.waiting_questions() == []
    settled = store.get_sweep(sweep.id)
    assert (settled.is_asking, settled.status) == (False, SweepStatus.FINISHED)
    assert store.go_on_asking(sweep.id, store.sweep_version(sweep.id), BATCH) == 0


def test_what_was_seen_before_another_batch_is_not_written(store: Store, sweep: Sweep) -> None:
    seen = store.sweep_version(sweep.id)
    store.go_on_asking(sweep.id, seen, BATCH)
    end_all(store)
    assert store.waiting_questions() == [sweep.id]
    for late in (BATCH, {}, {("Pendulum", 0): (4, 0, 5, 6)}):
        assert store.go_on_asking(sweep.id, seen, late) == 0
    assert store.waiting_questions() == [sweep.id]
    assert store.get_sweep(sweep.id).runs.total == 6


@pytest.mark.parametrize("late", [BATCH, {}], ids=["a batch", "settled"])
def test_what_was_seen_before_a_run_was_trained_again_is_not_written(
    store: Store, late: dict[tuple[str, int], tuple[int, ...]]
) -> None:
    """The sweep has as many runs as before, but other measurements."""
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in (0, 1)]
    sweep = store.create_sweep("x", 0, QUESTION, specs, environment_versions={"Pendulum": 1})
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    store.record(claim, Progress(1600, finished=(0,), failed=(Failure(1, 0, "x"),)))
    seen = store.sweep_version(sweep.id)
    store.move_run(f"{sweep.id}-1", "retry")
    end_all(store)
    assert store.waiting_questions() == [sweep.id]
    assert store.go_on_asking(sweep.id, seen, late) == 0
    assert store.waiting_questions() == [sweep.id]
    assert store.get_sweep(sweep.id).runs.total == 2


def test_a_sweep_that_is_gone_gets_none(store: Store, sweep: Sweep) -> None:
    seen = store.sweep_version(sweep.id)
    store.delete_sweep(sweep.id)
    assert store.waiting_questions() == []
    for name in (sweep.id, "no-such-sweep"):
        assert store.go_on_asking(name, seen, BATCH) == 0
        assert store.go_on_asking(name, store.sweep_version(name), BATCH) == 0


def test_a_retry_reopens_the_question(store: Store) -> None:
    specs = [RunSpec("ddpg", "Pendulum", 0, timesteps=1600)]
    sweep = store.create_sweep("x", 0, QUESTION, specs, environment_versions={"Pendulum": 1})
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    store.fail(claim, "Traceback", "")
    store.go_on_asking(sweep.id, store.sweep_version(sweep.id), {})
    assert not store.get_sweep(sweep.id).is_asking
    store.move_run(f"{sweep.id}-0", "retry")
    assert store.get_sweep(sweep.id).is_asking
