"""Rungs of a search: written once, of what was seen, on every database."""

import pytest

from algorithms.early_end import Divergence
from service.model.inquiry.search import Rung, Search
from service.model.run import RunStatus
from service.model.sweep import Sweep, SweepStatus
from service.store.store import Store
from tests.service.store.conftest import measured
from workers.messages.progress import Progress
from workers.messages.run_spec import NO_WEIGHTS, RunSpec

SEARCH = Search(100_000, 3, "area", (10, 11), {"Pendulum": (Rung(4, 800), Rung(2, 2400))})
NEXT = {("Pendulum", 1): 2400, ("Pendulum", 2): 2400}


@pytest.fixture
def sweep(store: Store) -> Sweep:
    """One whose four entries have ended the first rung; a run of the third has diverged."""
    specs = [
        RunSpec("ddpg", "Pendulum", seed, NO_WEIGHTS, 800, {"noise": place / 10})
        for place in range(4)
        for seed in SEARCH.seeds
    ]
    places = [place for place in range(4) for _ in SEARCH.seeds]
    sweep = store.create_sweep(
        "x", 0, {"seeds": 2}, specs, entries=places, environment_versions={"Pendulum": 1},
        search=SEARCH,
    )  # fmt: skip
    assert sweep.is_asking
    assert store.waiting_questions() == []
    while claim := store.claim_cohort("w", 60.0):
        diverges = claim.specs[0].config["noise"] == 0.2
        lost = (Divergence(11, 400, 1, "loss"),) if diverges else ()
        ended = [spec.seed for spec in claim.specs if not (diverges and spec.seed == 11)]
        points = tuple(measured(seed, 800) for seed in ended)
        store.record(
            claim, Progress(800, measurements=points, finished=tuple(ended), diverged=lost)
        )
    return sweep


def test_what_was_planned_is_read_back(store: Store, sweep: Sweep) -> None:
    assert sweep.search == SEARCH
    assert [each.id for each in store.list_searches()] == [sweep.id]
    plain = [RunSpec("ddpg", "Pendulum", 0, timesteps=800)]
    other = store.create_sweep("x", 0, {"seeds": 1}, plain, environment_versions={"Pendulum": 1})
    assert other.search is None
    assert [each.id for each in store.list_searches()] == [sweep.id]


def test_the_best_cells_go_on_and_once(store: Store, sweep: Sweep) -> None:
    assert store.waiting_questions() == [sweep.id]
    seen = store.sweep_version(sweep.id)
    assert store.go_on_searching(sweep.id, seen, NEXT) == 4
    for _ in range(2):
        assert store.go_on_searching(sweep.id, seen, NEXT) == 0
    runs = store.list_runs(sweep.id)
    assert [(run.entry, run.spec.timesteps, run.status.value) for run in runs] == [
        (0, 800, "succeeded"), (0, 800, "succeeded"),
        (1, 2400, "queued"), (1, 2400, "queued"),
        (2, 2400, "queued"), (2, 2400, "diverged"),  # as it would again
        (3, 800, "succeeded"), (3, 800, "succeeded"),
    ]  # fmt: skip
    assert runs[2].timestep == 800
    assert len(store.measurements(runs[2].id)) == 1
    assert store.waiting_questions() == []
    changes = [each.payload["change"] for each in store.events_after(0) if each.kind == "sweep"]
    assert changes == ["created", "extended"]


def test_cells_that_lack_nothing_settle_the_search(store: Store, sweep: Sweep) -> None:
    seen = store.sweep_version(sweep.id)
    assert store.go_on_searching(sweep.id, seen, {("Pendulum", 0): 800}) == 0
    assert store.events_after(0)[-1].payload == {"sweep_id": sweep.id, "change": "answered"}
    settled = store.get_sweep(sweep.id)
    assert (settled.is_asking, settled.status) == (False, SweepStatus.FINISHED)
    assert store.go_on_searching(sweep.id, store.sweep_version(sweep.id), NEXT) == 0


def test_what_was_seen_before_another_rung_is_not_written(store: Store, sweep: Sweep) -> None:
    seen = store.sweep_version(sweep.id)
    store.go_on_searching(sweep.id, seen, NEXT)
    while claim := store.claim_cohort("w", 60.0):
        store.record(claim, Progress(2400, finished=tuple(spec.seed for spec in claim.specs)))
    for late in (NEXT, {}, {("Pendulum", 0): 2400}):
        assert store.go_on_searching(sweep.id, seen, late) == 0
    assert store.waiting_questions() == [sweep.id]
    assert {run.status for run in store.list_runs(sweep.id)} == {
        RunStatus.SUCCEEDED, RunStatus.DIVERGED,
    }  # fmt: skip


def test_a_sweep_that_is_gone_goes_no_further(store: Store, sweep: Sweep) -> None:
    seen = store.sweep_version(sweep.id)
    store.delete_sweep(sweep.id)
    assert store.list_searches() == []
    for name in (sweep.id, "no-such-sweep"):
        assert store.go_on_searching(name, seen, NEXT) == 0
        assert store.go_on_searching(name, store.sweep_version(name), NEXT) == 0
