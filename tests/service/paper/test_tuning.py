"""The tuning's definition: every sweep can be submitted, and no seed is the evaluation's."""

import pytest

from algorithms.presets import preset
from service.paper import tuning
from service.paper.evaluation import COMPARISON, SEEDS, evaluation
from service.paper.tuning import Outcome, best
from service.schemas.sweep_request import SweepRequest
from service.submission.plan import Plan
from service.submission.plan import plan as plan_in

WORKER_MEMORY = 16 * 2**30


def plan(request: SweepRequest) -> Plan:
    """Return the plan of a sweep for workers that have room for each of its runs."""
    return plan_in(request, WORKER_MEMORY)


@pytest.mark.parametrize("environment", tuning.TIMESTEPS)
@pytest.mark.parametrize("baseline", tuning.HYBRIDS)
def test_a_search_can_be_submitted(environment: str, baseline: str) -> None:
    settings = plan(SweepRequest(**tuning.settings_sweep(environment, baseline)))
    names = tuning.searched_settings(environment, baseline)
    assert all(name in cell.config for cell in settings.cells for name in names)
    chosen = {name: settings.cells[0].config[name] for name in names}
    weights = plan(SweepRequest(**tuning.weights_sweep(environment, baseline, chosen)))
    pairs = {cell.weights for cell in weights.cells}
    assert len(pairs) == len(tuning.PAIRS) == 15
    assert {"w1 alone": (1.0, 0.0) in pairs, "w2 alone": (0.0, 0.01) in pairs} == {
        "w1 alone": True,
        "w2 alone": True,
    }


def test_no_seed_of_the_tuning_is_evaluated() -> None:
    assert not set(tuning.SEEDS) & set(range(SEEDS))


def test_the_first_of_the_best_is_chosen() -> None:
    rows = [
        Outcome("Pendulum", "ddpg", (0.0, 0.0), {"noise": noise}, area, 0.0, 4, "a")
        for noise, area in ((0.2, 0.1), (0.4, 0.3), (0.6, 0.3), (0.8, float("-inf")))
    ]
    assert best(rows, "ddpg").config == {"noise": 0.4}
    with pytest.raises(ValueError, match="empty"):
        best(rows, "sac")


def test_the_evaluation_has_every_method_where_it_applies() -> None:
    critic, comparison = (plan(SweepRequest(**request)) for request in evaluation(2))
    assert {cell.timesteps for cell in critic.cells} == {60_000}
    cells = {(cell.algorithm, cell.environment) for cell in comparison.cells}
    assert len(cells) == len(comparison.cells) == 7 + 7 + 6 + 6 + 7 + 5 + 5
    assert ("mpc", "Acrobot") not in cells
    assert ("sac", "HalfCheetah") not in cells
    for cell in comparison.cells:
        assert cell.timesteps == preset(cell.algorithm, cell.environment).timesteps
    assert set(COMPARISON["environments"]) == {cell.environment for cell in comparison.cells}


def test_a_quick_look_takes_a_share_of_the_timesteps() -> None:
    _, comparison = (plan(SweepRequest(**request)) for request in evaluation(1, scale=0.02))
    longest = max(cell.timesteps for cell in comparison.cells)
    assert longest <= 0.02 * 1_488_000 + 800
