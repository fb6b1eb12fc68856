"""The rounds of a search: which runs go on, and that nothing but what was measured decides it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from algorithms.early_end import Divergence, Failure
from algorithms.measurement import Measurement
from service.model.inquiry.search import Search, rungs_of, search_seeds
from service.model.sweep import Sweep, SweepStatus
from service.queue.question_rounds import look_at_all
from service.queue.search_rounds import Rung, ladders_of, next_rung
from service.store.claiming.retry import RetryPolicy
from service.store.refusal import ImpossibleMoveError
from service.store.store import Store
from tests.service.memory_database import in_memory
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import NO_WEIGHTS, RunSpec

STEPS = 2400
SEEDS = search_seeds(2)
BEST = {"Pendulum": 0.4, "MassPoint": 0.1}
Look = tuple[str | None, Rung]
NOISES = [0.1, 0.2, 0.3, 0.4, 0.5]
WHOLE = 2 * (5 * 800 + 2 * 1600)
"""Timesteps of a task: five entries to 800, two of them to 2400, with two seeds."""


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = prepared(Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}"))
    yield opened
    opened.close()


def prepared(store: Store) -> Store:
    for task in BEST:
        store.record_random_return(RandomReturn(task, 1, -100.0, -101.0, -99.0, 1000))
    return store


def searching(store: Store, tasks: tuple[str, ...] = ("Pendulum",)) -> Sweep:
    """A sweep of five entries, two seeds and two rungs."""
    rungs = dict.fromkeys(tasks, rungs_of(5, STEPS, 3))
    request = {
        "algorithms": [{"name": "ddpg", "config": {"noise": NOISES}}],
        "environments": list(tasks),
        "seeds": 2,
        "search": {"budget": 10**6},
    }
    specs = [
        RunSpec("ddpg", task, seed, NO_WEIGHTS, 800, {"noise": noise})
        for task in tasks
        for noise in NOISES
        for seed in SEEDS
    ]
    places = [NOISES.index(spec.config["noise"]) for spec in specs]
    search = Search(10**6, 3, "area", SEEDS, rungs)
    return store.create_sweep(
        "x", 0, request, specs, entries=places, environment_versions=dict.fromkeys(tasks, 1),
        search=search,
    )  # fmt: skip


def measured(spec: RunSpec) -> tuple[Measurement, ...]:
    """A curve that tells of its noise and seed, and of no one who trains it."""
    worth = 1 - abs(spec.config["noise"] - BEST[spec.environment]) + 0.01 * (spec.seed % 2)
    values = {step: 100 * worth * step / STEPS - 100 for step in range(800, STEPS + 1, 800)}
    return tuple(
        Measurement(spec.seed, step, value, value, 1, 0, 1.0, {}, 0.0)
        for step, value in values.items()
        if step <= spec.timesteps
    )


def train(store: Store, most: int = 1000) -> int:
    """Train so many cohorts of what waits; return how many there were."""
    for trained in range(most):
        if (claim := store.claim_cohort("w", 60.0)) is None:
            return trained
        points = tuple(point for spec in claim.specs for point in measured(spec))
        ended = tuple(spec.seed for spec in claim.specs)
        steps = claim.specs[0].timesteps
        store.record(claim, Progress(steps, measurements=points, finished=ended))
    return most


def lengths(store: Store, sweep: Sweep) -> dict[tuple[str, float], set[int]]:
    """The timesteps of the runs of each entry."""
    found: dict[tuple[str, float], set[int]] = {}
    for run in store.list_runs(sweep.id, limit=1000):
        cell = run.spec.environment, run.spec.config["noise"]
        found.setdefault(cell, set()).add(run.spec.timesteps)
    return found


def winners(store: Store, sweep: Sweep) -> dict[str, str | None]:
    again = store.get_sweep(sweep.id)
    assert again.search is not None
    return {
        ladder.environment: None if ladder.winner is None else ladder.winner.label
        for ladder in ladders_of(store, again, again.search)
    }


def test_the_best_of_each_task_go_on(store: Store) -> None:
    sweep = searching(store, tuple(BEST))
    assert sweep.search is not None
    assert (sweep.status, sweep.progress, sweep.search.timesteps) == ("queued", 0.0, 2 * WHOLE)
    assert look_at_all(store) == 0  # its first rung is not over
    train(store)
    half = store.get_sweep(sweep.id)
    assert (half.status, half.is_asking) == (SweepStatus.RUNNING, True)
    assert half.progress == pytest.approx(2 * 10 * 800 / (2 * WHOLE))
    assert half.eta_seconds is not None
    assert half.eta_seconds > 0
    assert look_at_all(store) == 8
    assert store.get_sweep(sweep.id).progress == pytest.approx(half.progress)
    longer = {cell for cell, steps in lengths(store, sweep).items() if steps == {STEPS}}
    assert {noise for task, noise in longer if task == "Pendulum"} == {0.3, 0.4}
    assert {noise for task, noise in longer if task == "MassPoint"} == {0.1, 0.2}
    train(store)
    assert look_at_all(store) == 0
    ended = store.get_sweep(sweep.id)
    assert (ended.status, ended.is_asking, ended.progress) == (SweepStatus.FINISHED, False, 1.0)
    assert ended.eta_seconds == 0.0
    assert winners(store, sweep) == {"Pendulum": "ddpg noise=0.4", "MassPoint": "ddpg noise=0.1"}
    changes = [e.payload["change"] for e in store.events_after(0) if e.kind == "sweep"]
    assert changes == ["created", "extended", "answered"]


def test_runs_go_on_from_where_they_ended(store: Store) -> None:
    """They are those of any sweep that is extended: the same runs, with what they measured."""
    sweep = searching(store)
    train(store)
    look_at_all(store)
    again = [run for run in store.list_runs(sweep.id, limit=100) if run.status == "queued"]
    assert {run.timestep for run in again} == {800}
    assert {run.reason for run in again} == {"it is among the best of its search"}
    assert [point.timestep for point in store.measurements(again[0].id)] == [800]
    with pytest.raises(ImpossibleMoveError, match="searches, which says what runs it gets"):
        store.extend_sweep(sweep.id, sweep.request, 9600, lambda _: 1)


def test_a_pause_holds_the_next_rung_back(store: Store) -> None:
    sweep = searching(store)
    train(store)
    store.move_sweep(sweep.id, "pause")
    assert look_at_all(store) == 4
    assert train(store) == 0
    store.move_sweep(sweep.id, "resume")
    assert train(store) > 0


def test_cancelled_between_two_rungs_nothing_goes_on(store: Store) -> None:
    sweep = searching(store)
    train(store)
    seen, rung = next_of(store, sweep)
    store.move_sweep(sweep.id, "cancel")
    assert store.go_on_searching(sweep.id, seen, rung) == look_at_all(store) == 0
    assert store.get_sweep(sweep.id).progress == 1.0  # of what is still asked for
    store.move_sweep(sweep.id, "uncancel")
    assert look_at_all(store) == 4


def test_where_every_run_fails_there_is_no_winner_until_they_are_retried(store: Store) -> None:
    sweep = searching(store)
    while claim := store.claim_cohort("w", 60.0):
        failed = tuple(Failure(spec.seed, 0, "x") for spec in claim.specs)
        store.record(claim, Progress(800, failed=failed))
    assert look_at_all(store) == 0
    assert store.get_sweep(sweep.id).status is SweepStatus.FINISHED
    assert winners(store, sweep) == {"Pendulum": None}
    store.move_sweep(sweep.id, "retry")
    while train(store):
        look_at_all(store)
    assert winners(store, sweep) == {"Pendulum": "ddpg noise=0.4"}


def test_an_entry_that_diverges_wholly_is_trained_no_further(store: Store) -> None:
    sweep = searching(store)
    train(store)
    look_at_all(store)
    while claim := store.claim_cohort("w", 60.0):
        lost = tuple(Divergence(spec.seed, 1600, 1, "loss") for spec in claim.specs)
        store.record(claim, Progress(1600, diverged=lost))
    look_at_all(store)
    assert store.get_sweep(sweep.id).status is SweepStatus.FINISHED
    assert winners(store, sweep) == {"Pendulum": "ddpg noise=0.3"}  # of equals the first


def next_of(store: Store, sweep: Sweep) -> Look:
    """The version of a search, and the rung that follows from it."""
    assert sweep.search is not None
    return store.sweep_version(sweep.id), next_rung(store, sweep, sweep.search)


ACTS = st.sampled_from(["train", "look", "write", "write again", "kill"])


@settings(max_examples=60, deadline=None)
@given(st.lists(ACTS, max_size=30))
def test_killed_at_any_moment_the_same_entries_climb(acts: list[str]) -> None:
    """A look may be written late, twice, or by a service that was killed before; never twice."""
    engine = in_memory(lambda: 1000.0)
    store = prepared(Store(engine, engine, RetryPolicy()))
    sweep = searching(store)
    looks: list[Look] = []
    given_more = 0
    for act in acts:
        if act == "train":
            train(store, 1)
        elif act == "look" and store.waiting_questions():
            looks.append(next_of(store, sweep))
        elif act == "write" and looks:
            given_more += store.go_on_searching(sweep.id, *looks[-1])
        elif act == "write again" and looks:
            given_more += store.go_on_searching(sweep.id, *looks[0])
        elif act == "kill":
            looks = looks[:1]
    while train(store) or store.waiting_questions():
        given_more += look_at_all(store)
    assert given_more == 4
    expected = {n: {STEPS} if n in (0.3, 0.4) else {800} for n in NOISES}
    assert lengths(store, sweep) == {("Pendulum", n): steps for n, steps in expected.items()}
    assert winners(store, sweep) == {"Pendulum": "ddpg noise=0.4"}
    store.close()
