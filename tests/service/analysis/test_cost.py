"""The cost of a sweep: from the finished runs most like it, else from built-in figures."""

import math

import pytest

import physics
from algorithms import catalogue
from physics.catalogue import OWN
from service.analysis.cost import (
    CellCost,
    PastCost,
    cell_costs,
    explain,
    total_core_seconds,
    wall_seconds,
)
from workers.messages.run_spec import RunSpec

DDPG = RunSpec("ddpg", "Pendulum", 0, timesteps=20_000, config={"noise": 0.4})


def past(seconds: float, timesteps: int = 10_000, **config: float) -> PastCost:
    return PastCost("ddpg", "Pendulum", config, timesteps, seconds)


def cost(cell: RunSpec, *finished: PastCost, seeds: int = 1) -> CellCost:
    (found,) = cell_costs([cell], seeds, finished)
    return found


def test_runs_with_the_same_settings_count_alone() -> None:
    """10 s for 10,000 steps and 30 s for 20,000: 4/3 ms a step, times 20,000 steps of 3 seeds."""
    found = cost(DDPG, past(10, noise=0.4), past(30, 20_000, noise=0.4), past(99), seeds=3)
    assert found.core_seconds == pytest.approx(80)
    assert (found.basis, found.runs) == ("same settings", 2)


def test_else_those_of_the_same_algorithm_and_environment() -> None:
    found = cost(DDPG, past(10), PastCost("sac", "Pendulum", {"noise": 0.4}, 1, 1e9))
    assert found.core_seconds == pytest.approx(20)
    assert (found.basis, found.runs) == ("same algorithm and environment", 1)


def test_else_a_built_in_figure() -> None:
    found = cost(DDPG)
    assert found.core_seconds == pytest.approx(20 * catalogue.find("ddpg").core_seconds["Pendulum"])
    assert (found.basis, found.runs) == ("built-in figures", 0)


def test_built_in_figures_cover_all_that_can_be_trained() -> None:
    able = {
        (task, algorithm)
        for task in OWN
        for algorithm in catalogue.names()
        if physics.make(task).reward_is_differentiable
        or not catalogue.find(algorithm).needs_reward_gradient
    }
    figures = {
        (task, algorithm): value
        for algorithm in catalogue.names()
        for task, value in catalogue.find(algorithm).core_seconds.items()
    }
    assert set(figures) == able
    assert all(value > 0 for value in figures.values())


@pytest.mark.parametrize(("algorithm", "task"), [("mine", "Pendulum"), ("ddpg", "mujoco/Hopper")])
def test_an_algorithm_of_others_and_a_task_of_an_extra_are_not_known(
    algorithm: str, task: str
) -> None:
    found = cost(RunSpec(algorithm, task, 0))
    assert (found.basis, found.runs) == ("unknown", 0)
    assert math.isnan(found.core_seconds)


def test_wall_time_shares_the_known_costs_among_the_workers() -> None:
    costs = [
        CellCost(30.0, "same settings", 4),
        CellCost(math.nan, "unknown", 0),
        CellCost(10.0, "same settings", 1),
    ]
    assert total_core_seconds(costs) == 40
    assert wall_seconds(costs, 4) == 10
    assert math.isnan(wall_seconds(costs, 0))
    assert math.isnan(total_core_seconds(costs[1:2]))
    assert explain(costs) == (
        "2 of 3 cells from finished runs with the same settings; 1 of 3 cells are of unknown cost "
        "and left out: no run like theirs has finished."
    )
