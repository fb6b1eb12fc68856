"""What is added to a sweep: seeds, entries, timesteps; whole or not at all."""

import math
from dataclasses import replace
from typing import Any

import pytest

from service.model.run import RunStatus
from service.model.sweep import RunCounts, Sweep, SweepStatus
from service.store.refusal import ImpossibleMoveError
from service.store.store import Store
from service.store.upkeep.integrity import check
from tests.service.store.conftest import measured
from workers.messages.progress import CheckpointAttempt, Progress, Resumption
from workers.messages.run_spec import RunSpec

REQUEST: dict[str, Any] = {
    "algorithms": [{"name": "ddpg"}, {"name": "sac"}],
    "environments": ["Pendulum"],
    "seeds": 2,
    "timesteps": 1600,
}


def one(environment: str) -> int:
    del environment
    return 1


def submitted(store: Store) -> Sweep:
    """Two entries of two seeds each, in one task."""
    specs = [
        RunSpec(name, "Pendulum", seed, timesteps=1600)
        for name in ("ddpg", "sac")
        for seed in (0, 1)
    ]
    versions = {"Pendulum": 1}
    return store.create_sweep(
        "x", 0, REQUEST, specs, entries=[0, 0, 1, 1], environment_versions=versions
    )


def ended(store: Store) -> Sweep:
    """The same, its runs at their end, with checkpoints of it."""
    sweep = submitted(store)
    while (claim := store.claim_cohort("w", 60.0)) is not None:
        seeds = tuple(spec.seed for spec in claim.specs)
        store.record(
            claim,
            Progress(
                1600,
                measurements=tuple(measured(s, t) for s in seeds for t in (800, 1600)),
                finished=seeds,
                checkpoints=tuple(CheckpointAttempt(seed, 1600) for seed in seeds),
                fingerprint={"code": "a"},
            ),
        )
    return sweep


def test_seeds_are_added_to_every_cell(store: Store) -> None:
    sweep = ended(store)
    grown = store.add_seeds(sweep.id, REQUEST, [2, 7], one)
    assert grown.runs == RunCounts(queued=4, succeeded=4)
    assert grown.status is SweepStatus.RUNNING
    assert grown.request == {**REQUEST, "seeds": [0, 1, 2, 7]}
    new = store.list_runs(sweep.id)[4:]
    assert [(run.id, run.entry, run.spec.algorithm, run.spec.seed) for run in new] == [
        (f"{sweep.id}-4", 0, "ddpg", 2),
        (f"{sweep.id}-5", 0, "ddpg", 7),
        (f"{sweep.id}-6", 1, "sac", 2),
        (f"{sweep.id}-7", 1, "sac", 7),
    ]
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    assert [run.run_id for run in claim.runs] == [f"{sweep.id}-4", f"{sweep.id}-5"]
    assert all(not each.faults for each in store.read(check))


def test_seeds_that_go_on_stay_a_number(store: Store) -> None:
    sweep = submitted(store)
    grown = store.add_seeds(sweep.id, REQUEST, [2, 3], one)
    assert grown.request["seeds"] == 4


def test_entries_are_added_after_those_that_there_are(store: Store) -> None:
    sweep = ended(store)
    whole = {**REQUEST, "algorithms": [*REQUEST["algorithms"], {"name": "td3"}]}
    specs = [RunSpec("td3", "Pendulum", seed, timesteps=1600) for seed in (0, 1)]
    grown = store.add_entries(sweep.id, REQUEST, whole, specs, [2, 2], one)
    assert grown.request == whole
    assert [run.entry for run in store.list_runs(sweep.id)] == [0, 0, 1, 1, 2, 2]
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    assert claim.specs == tuple(specs)
    assert all(not each.faults for each in store.read(check))


def test_runs_go_on_to_more_timesteps(store: Store) -> None:
    sweep = ended(store)
    assert store.list_runs(sweep.id)[0].score == -1.0
    for _ in range(2):  # again: no error, no change
        longer = store.extend_sweep(sweep.id, store.sweep_request(sweep.id), 3200, one)
        assert longer.runs == RunCounts(queued=4)
        assert longer.progress == 0.5
    assert longer.request["timesteps"] == 3200
    run = store.list_runs(sweep.id)[0]
    assert (run.status, run.spec.timesteps, run.checkpoint_timestep) == ("queued", 3200, 1600)
    assert run.finished_at is None
    assert math.isnan(run.score)
    assert len(store.measurements(run.id)) == 2
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    assert claim.specs[0] == replace(run.spec, seed=0)
    store.record(claim, Progress(1600, fingerprint={"code": "a"}, resumed=(Resumption(0, 1600),)))
    assert len(store.measurements(run.id)) == 2
    assert all(not each.faults for each in store.read(check))


def test_a_point_that_was_only_the_end_goes(store: Store) -> None:
    """A longer run is measured on the grid alone."""
    spec = RunSpec("ddpg", "Pendulum", 0, timesteps=1000)
    request = {"algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"], "seeds": 1}
    sweep = store.create_sweep("x", 0, request, [spec], environment_versions={"Pendulum": 1})
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    points = (measured(0, 800), measured(0, 1000))
    store.record(claim, Progress(1000, measurements=points, finished=(0,)))
    store.extend_sweep(sweep.id, request, 1600, one)
    assert [m.timestep for m in store.measurements(f"{sweep.id}-0")] == [800]


def test_what_was_not_at_its_end_gets_more_timesteps_and_stays_where_it_is(store: Store) -> None:
    sweep = submitted(store)
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    store.fail(claim, "ValueError: no")
    store.move_run(f"{sweep.id}-2", "cancel")
    longer = store.extend_sweep(sweep.id, REQUEST, 3200, one)
    assert longer.runs == RunCounts(queued=1, failed=2, cancelled=1)
    assert {run.spec.timesteps for run in store.list_runs(sweep.id)} == {3200}
    store.move_sweep(sweep.id, "retry")
    assert store.move_sweep(sweep.id, "uncancel").runs == RunCounts(queued=4)


def test_nothing_is_extended_while_it_trains(store: Store) -> None:
    sweep = submitted(store)
    store.claim_cohort("w", 60.0)
    with pytest.raises(ImpossibleMoveError, match=r"2 runs of sweep .* are in training"):
        store.extend_sweep(sweep.id, REQUEST, 3200, one)
    assert {run.spec.timesteps for run in store.list_runs(sweep.id)} == {1600}


def test_what_is_added_to_a_paused_sweep_waits_with_it(store: Store) -> None:
    sweep = ended(store)
    store.add_seeds(sweep.id, REQUEST, [2], one)
    store.move_sweep(sweep.id, "pause")
    seen = store.sweep_request(sweep.id)
    grown = store.add_seeds(sweep.id, seen, [3], one)
    assert grown.runs == RunCounts(paused=4, succeeded=4)
    longer = store.extend_sweep(sweep.id, grown.request, 3200, one)
    assert longer.runs == RunCounts(paused=8)
    assert store.claim_cohort("w", 60.0) is None


def test_impossible_additions_say_why_and_change_nothing(store: Store) -> None:
    sweep = submitted(store)
    with pytest.raises(ImpossibleMoveError, match="was changed meanwhile: load it again"):
        store.add_seeds(sweep.id, {**REQUEST, "seeds": 3}, [5], one)
    with pytest.raises(ImpossibleMoveError, match=r"version 1 of Pendulum, and .* has version 2"):
        store.add_seeds(sweep.id, REQUEST, [5], lambda _: 2)
    with pytest.raises(ImpossibleMoveError, match="has version 2"):
        store.extend_sweep(sweep.id, REQUEST, 3200, lambda _: 2)
    store.move_sweep(sweep.id, "cancel")
    with pytest.raises(ImpossibleMoveError, match="was cancelled: uncancel it first"):
        store.add_seeds(sweep.id, REQUEST, [5], one)
    assert len(store.list_runs(sweep.id)) == 4


def test_cancelled_runs_are_queued_again(store: Store) -> None:
    sweep = submitted(store)
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    store.record(claim, Progress(1600, finished=(0,)))
    store.move_sweep(sweep.id, "cancel")
    store.record(claim.only({f"{sweep.id}-1"}), Progress(1600, dropped=(1,)))
    with pytest.raises(ImpossibleMoveError, match="uncancel it"):
        store.move_run(f"{sweep.id}-2", "uncancel")
    for _ in range(2):
        again = store.move_sweep(sweep.id, "uncancel")
        assert again.runs == RunCounts(queued=3, succeeded=1)
        assert again.status is SweepStatus.RUNNING
    store.move_run(f"{sweep.id}-2", "cancel")
    assert store.move_run(f"{sweep.id}-2", "uncancel").status is RunStatus.QUEUED
    with pytest.raises(ImpossibleMoveError, match="only cancelled runs are uncancelled"):
        store.move_run(f"{sweep.id}-0", "uncancel")
    assert all(not each.faults for each in store.read(check))


def test_a_sweep_holds_no_more_workers_than_it_may(store: Store) -> None:
    sweep = submitted(store)
    store.edit_sweep(sweep.id, {"max_workers": 1})
    other = submitted(store)
    first, second, third, none = store.claim_all([(f"w{i}", 2) for i in range(4)], 60.0)
    assert first is not None
    assert second is not None
    assert third is not None
    assert none is None
    held = [claim.runs[0].run_id.partition("-")[0] for claim in (first, second, third)]
    assert sorted(held) == sorted([sweep.id, other.id, other.id])
    assert store.waiting_cells(limit=100) == []
    [own] = [c for c in (first, second, third) if c.runs[0].run_id.startswith(sweep.id)]
    store.record(own, Progress(1600, finished=(0, 1)))
    assert store.waiting_cells(limit=100) == [2]
    assert store.claim_cohort("w9", 60.0) is not None
    assert store.edit_sweep(sweep.id, {"max_workers": None}).max_workers is None
