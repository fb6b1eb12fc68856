"""The evaluation's sweeps: each can be submitted, and each run belongs to one."""

from collections import Counter
from typing import Any

import physics
from algorithms import catalogue
from algorithms.presets import preset
from service.api.schemas.requests.sweep_request import SweepRequest
from service.api.submission.plan import plan as plan_in
from service.model.request.entry import Entries
from service.model.request.plan import Plan
from service.paper.evaluation import (
    COMPARISON,
    MORE_TASKS,
    SEEDS,
    SOFT,
    SWEEPS,
    TASKS,
    evaluation,
    row,
)
from service.paper.search import tuning

WORKER_MEMORY = 16 * 2**30


def plan(request: dict[str, Any]) -> Plan:
    """Return the plan of a sweep for workers that have room for each of its runs."""
    return plan_in(SweepRequest(**request), WORKER_MEMORY)


def plans(seeds: int = 2, scale: float = 1.0) -> dict[str, Plan]:
    return {request["name"]: plan(request) for request in evaluation(seeds, scale)}


def test_no_seed_of_the_tuning_is_evaluated() -> None:
    assert not set(tuning.SEEDS) & set(range(SEEDS))


def test_the_papers_comparison_comes_first_and_has_the_most_seeds() -> None:
    first, *others = evaluation()
    assert first["name"] == COMPARISON["name"]
    assert first["seeds"] == SEEDS == 32
    assert {request["seeds"] for request in others} == {16}
    priorities = [request["priority"] for request in (first, *others)]
    assert priorities == sorted(set(priorities), reverse=True)
    assert {request["seeds"] for request in evaluation(seeds=3)} == {3}


def test_no_run_belongs_to_two_sweeps() -> None:
    cells = Counter(
        (row(cell.algorithm, cell.config), cell.environment, cell.weights)
        for each in plans().values()
        for cell in each.cells
    )
    assert set(cells.values()) == {1}


def test_every_learner_is_evaluated_in_ten_tasks() -> None:
    """But where an algorithm needs a gradient that the task's reward has not."""
    where: dict[str, set[str]] = {}
    for each in plans().values():
        for cell in each.cells:
            where.setdefault(row(cell.algorithm, cell.config), set()).add(cell.environment)
    assert set(where) == {*catalogue.OWN, "sac with learned temperature"}
    tasks = (*TASKS, *MORE_TASKS)
    smooth = {name for name in tasks if physics.make(name).reward_is_differentiable}
    for name, found in where.items():
        able = {*tasks}
        if name in catalogue.OWN and catalogue.find(name).needs_reward_gradient:
            able &= smooth
        assert found - {"MassPoint"} == able
    assert {*tasks, "MassPoint"} == {*tuning.TIMESTEPS, *tuning.AS_ON}


def test_runs_have_the_presets_length_but_for_the_critics() -> None:
    for name, each in plans().items():
        for cell in each.cells:
            usual = preset(cell.algorithm, cell.environment).timesteps
            assert cell.timesteps == (60_000 if "critic of the" in name else usual)


def test_the_papers_sweeps_are_the_papers() -> None:
    found = plans()
    comparison, soft = found[COMPARISON["name"]], found[SOFT["name"]]
    cells = {(cell.algorithm, cell.environment) for cell in comparison.cells}
    assert len(cells) == len(comparison.cells) == 4 * 7 + 2 * 6
    assert ("mpc", "Acrobot") not in cells
    assert len(soft.cells) == 5 + 5


def test_a_quick_look_takes_a_share_of_the_timesteps() -> None:
    longest = max(
        cell.timesteps for each in plans(seeds=1, scale=0.02).values() for cell in each.cells
    )
    assert longest <= 0.02 * 1_600_000 + 800


def test_a_form_has_a_row_of_its_own() -> None:
    assert row("sac", {"reward_scale": 3.0}) == row("sac", {"temperature": "fixed"}) == "sac"
    assert row("sac", {"temperature": "learned", "rate": 0.001}) == "sac with learned temperature"
    assert row("hybrid-sac", {"temperature": "learned"}) == "hybrid-sac with learned temperature"


def test_a_learner_goes_by_the_name_of_its_row_in_the_figures_of_its_sweep() -> None:
    for sweep in SWEEPS:
        for entry in Entries(sweep).all:
            if not isinstance(sweep["algorithms"][entry.item].get("weights"), list):
                assert entry.label == row(entry.algorithm, entry.config)
