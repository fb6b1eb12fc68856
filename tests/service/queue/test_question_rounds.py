"""The rounds of a question: which seeds it is given, and what becomes of it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from algorithms.early_end import Divergence, Failure
from algorithms.measurement import Measurement
from service.model.inquiry.question import Question
from service.model.sweep import Sweep, SweepStatus
from service.queue.question_rounds import QuestionRounds, look_at_all, next_batch
from service.store.reading.sweep_search import SweepSearch
from service.store.refusal import ImpossibleMoveError
from service.store.store import Store
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec

STEPS = 800
QUESTION = {"compare": ["hybrid-ddpg"], "with": "ddpg", "score": "final", "batch": 4, "clip": 0.25,
            "max_seeds": 40, "margin": 0.05}  # fmt: skip
GAINS = {"Pendulum": 0.2, "MassPoint": 0.0, "RollingDie": -0.2}


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}")
    for task in GAINS:
        opened.record_random_return(RandomReturn(task, 1, -100.0, -101.0, -99.0, 1000))
    yield opened
    opened.close()


def asking(store: Store, tasks: tuple[str, ...] = ("Pendulum",), **fields: Any) -> Sweep:
    """A sweep with four seeds and a question."""
    request = {
        "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg"}],
        "environments": list(tasks),
        "seeds": 4,
        "question": {**QUESTION, **fields},
    }
    specs = [
        RunSpec(name, task, seed, timesteps=STEPS)
        for task in tasks
        for name in ("ddpg", "hybrid-ddpg")
        for seed in range(4)
    ]
    places = [int(spec.algorithm == "hybrid-ddpg") for spec in specs]
    versions = dict.fromkeys(tasks, 1)
    return store.create_sweep("x", 0, request, specs, entries=places, environment_versions=versions)


def normalised(spec: RunSpec) -> float:
    """The score that a run reaches, on the scale from random (-100) to best (0)."""
    gain = GAINS[spec.environment] if spec.algorithm == "hybrid-ddpg" else 0.0
    return 0.5 + gain + 0.01 * (spec.seed % 3 - 1)


def train(store: Store, diverging: frozenset[str] = frozenset(), failing: bool = False) -> int:
    """Train all that waits; return how many runs that were."""
    trained = 0
    while claim := store.claim_cohort("w", 60.0):
        seeds = {spec.seed: spec for spec in claim.specs}
        if failing:
            progress = Progress(STEPS, failed=tuple(Failure(seed, 0, "x") for seed in seeds))
        elif claim.specs[0].algorithm in diverging:
            lost = tuple(Divergence(seed, STEPS, 1, "loss") for seed in seeds)
            progress = Progress(STEPS, diverged=lost)
        else:
            values = {seed: 100 * normalised(spec) - 100 for seed, spec in seeds.items()}
            measured = tuple(
                Measurement(seed, STEPS, value, value, 1, 0, 1.0, {}, 0.0)
                for seed, value in values.items()
            )
            progress = Progress(STEPS, measurements=measured, finished=tuple(seeds))
        store.record(claim, progress)
        trained += len(seeds)
    return trained


def seeds_of(store: Store, sweep: Sweep) -> dict[tuple[str, str], list[int]]:
    """The seeds of each cell."""
    found: dict[tuple[str, str], list[int]] = {}
    for run in store.list_runs(sweep.id, limit=1000):
        found.setdefault((run.spec.environment, run.spec.algorithm), []).append(run.spec.seed)
    return found


def test_each_task_gets_seeds_until_it_is_decided(store: Store) -> None:
    sweep = asking(store, tuple(GAINS))
    assert look_at_all(store) == 0  # its first batch is not trained yet
    while train(store):
        assert store.get_sweep(sweep.id).status is SweepStatus.RUNNING
        look_at_all(store)
    ended = store.get_sweep(sweep.id)
    assert (ended.status, ended.is_asking, ended.progress) == (SweepStatus.FINISHED, False, 1.0)
    counts = {cell: len(seeds) for cell, seeds in seeds_of(store, sweep).items()}
    assert counts["Pendulum", "ddpg"] == counts["Pendulum", "hybrid-ddpg"] == 12
    assert counts["RollingDie", "ddpg"] == counts["RollingDie", "hybrid-ddpg"] == 12
    assert counts["MassPoint", "ddpg"] == counts["MassPoint", "hybrid-ddpg"] == 28
    assert all(seeds == list(range(len(seeds))) for seeds in seeds_of(store, sweep).values())
    assert look_at_all(store) == 0
    changes = [e.payload["change"] for e in store.events_after(0) if e.kind == "sweep"]
    assert changes == ["created", *["extended"] * 6, "answered"]


def test_the_same_batch_asked_for_again_changes_nothing(store: Store) -> None:
    sweep = asking(store)
    train(store)
    seen, batch = store.sweep_version(sweep.id), next_batch(store, sweep)
    assert batch == {("Pendulum", place): tuple(range(8)) for place in (0, 1)}
    assert store.go_on_asking(sweep.id, seen, batch) == 8
    for _ in range(2):  # while it waits, and when it has ended
        assert store.go_on_asking(sweep.id, seen, batch) == 0
        train(store)
    assert store.get_sweep(sweep.id).is_asking
    assert store.get_sweep(sweep.id).runs.total == 16


def test_the_budget_settles_what_is_not_decided(store: Store) -> None:
    sweep = asking(store, ("MassPoint",), max_seeds=6)
    while train(store):
        look_at_all(store)
    assert seeds_of(store, sweep)["MassPoint", "ddpg"] == list(range(6))
    assert store.get_sweep(sweep.id).status is SweepStatus.FINISHED


def test_a_pause_holds_the_next_batch_back(store: Store) -> None:
    sweep = asking(store)
    train(store)
    assert store.move_sweep(sweep.id, "pause").status is SweepStatus.PAUSED
    assert look_at_all(store) == 8
    assert train(store) == 0
    assert store.move_sweep(sweep.id, "resume").status is SweepStatus.RUNNING
    assert train(store) == 8


def test_cancelled_between_two_batches_it_gets_none(store: Store) -> None:
    sweep = asking(store)
    train(store)
    seen, batch = store.sweep_version(sweep.id), next_batch(store, sweep)
    assert store.move_sweep(sweep.id, "cancel").status is SweepStatus.CANCELLED
    assert store.go_on_asking(sweep.id, seen, batch) == look_at_all(store) == 0
    assert len(seeds_of(store, sweep)["Pendulum", "ddpg"]) == 4
    for _ in range(2):
        assert store.move_sweep(sweep.id, "uncancel").status is SweepStatus.RUNNING
    assert look_at_all(store) == 8


def test_it_gets_no_other_runs(store: Store) -> None:
    sweep = asking(store)
    train(store)
    with pytest.raises(ImpossibleMoveError, match="asks a question"):
        store.add_seeds(sweep.id, sweep.request, [100], lambda _: 1)


def test_its_end_is_told_once_it_is_settled(store: Store) -> None:
    sweep = asking(store, max_seeds=4)
    store.edit_sweep(sweep.id, {"webhook": "https://example.org/hook"})
    train(store)
    assert store.due_webhooks(1) == []
    look_at_all(store)
    assert [due.sweep.id for due in store.due_webhooks(1)] == [sweep.id]


def test_code_that_fails_is_not_tried_on_further_seeds(store: Store) -> None:
    sweep = asking(store)
    train(store, failing=True)
    assert look_at_all(store) == 0
    assert store.get_sweep(sweep.id).status is SweepStatus.FINISHED
    store.move_sweep(sweep.id, "retry")  # the question is open again
    while train(store):
        look_at_all(store)
    assert len(seeds_of(store, sweep)["Pendulum", "ddpg"]) == 8


def test_a_divergence_counts_as_acting_at_random(store: Store) -> None:
    sweep = asking(store)
    while train(store, frozenset({"hybrid-ddpg"})):
        look_at_all(store)
    assert store.get_sweep(sweep.id).status is SweepStatus.FINISHED
    assert len(seeds_of(store, sweep)["Pendulum", "ddpg"]) == 8  # -0.25 each: worse


def test_a_sweep_without_a_question_is_left_alone(store: Store) -> None:
    specs = [RunSpec("ddpg", "Pendulum", 0, timesteps=STEPS)]
    sweep = store.create_sweep("x", 0, {"seeds": 1}, specs, environment_versions={"Pendulum": 1})
    train(store)
    assert look_at_all(store) == 0
    assert store.get_sweep(sweep.id).status is SweepStatus.FINISHED
    assert Question.of(sweep.request) is None


def test_the_thread_looks_by_itself(store: Store) -> None:
    sweep = asking(store)
    train(store)
    rounds = QuestionRounds(store, seconds=0.0)
    rounds.start()
    while store.get_sweep(sweep.id).runs.total == 8:
        pass
    rounds.stop()
    assert store.get_sweep(sweep.id).runs.total == 16


def test_a_list_finds_sweeps_by_the_status_that_they_show(store: Store) -> None:
    """Between two batches no run of theirs is active."""
    going, paused, cancelled = (asking(store) for _ in range(3))
    train(store)
    store.move_sweep(paused.id, "pause")
    store.move_sweep(cancelled.id, "cancel")
    answered = asking(store, max_seeds=4)
    train(store)
    look_at_all(store)
    expected = {
        going.id: "running", paused.id: "paused", cancelled.id: "cancelled", answered.id: "finished"
    }  # fmt: skip
    for sweep_id, shown in expected.items():
        assert store.get_sweep(sweep_id).status == shown
    for status in SweepStatus:
        listed = store.list_sweeps(search=SweepSearch(status=status))
        assert all(sweep.status == status for sweep in listed)
        assert len(listed) == list(expected.values()).count(status)
