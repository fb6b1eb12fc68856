"""The tuning's definition: every sweep can be submitted, and no seed is the evaluation's."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from algorithms.presets import preset
from service.api.schemas.curves_answer import CurveAnswer, CurvesAnswer, PanelAnswer
from service.api.schemas.run_answer import WeightsAnswer
from service.api.schemas.sweep_request import SweepRequest
from service.api.submission.plan import plan as plan_in
from service.cli.paper import read_tuning
from service.model.plan import Plan
from service.paper import tuning
from service.paper.evaluation import COMPARISON, SEEDS, evaluation
from service.paper.tuning import Outcome, best
from workers.messages.run_spec import Weights

WORKER_MEMORY = 16 * 2**30
RESULTS = Path(__file__).parents[3] / "results"


def plan(request: SweepRequest) -> Plan:
    """Return the plan of a sweep for workers that have room for each of its runs."""
    return plan_in(request, WORKER_MEMORY)


def requested(request: dict[str, Any] | None) -> SweepRequest:
    assert request is not None
    return SweepRequest(**request)


@pytest.mark.parametrize(
    ("hybrid", "environment"),
    [(hybrid, task) for hybrid in tuning.PAIRS for task in tuning.tasks(hybrid)],
)
def test_a_search_can_be_submitted(hybrid: str, environment: str) -> None:
    baseline = tuning.baseline(hybrid)
    request = tuning.settings_sweep(environment, baseline)
    settings = plan(requested(request))
    assert all(set(tuning.SETTINGS[baseline]) <= set(cell.config) for cell in settings.cells)
    assert request is not None
    chosen = request["algorithms"][0]["config"]
    weights = plan(requested(tuning.weights_sweep(environment, hybrid, chosen)))
    pairs = {cell.weights for cell in weights.cells}
    assert len(pairs) == (15 if hybrid == "hybrid-ddpg" else 9)
    assert {(1.0, 0.0), (0.0, 0.01)} <= pairs


def test_what_is_known_is_not_run_again() -> None:
    def outcome(weights: Weights, runs: int) -> Outcome:
        config = {"reward_scale": 3.0}
        return Outcome("Pendulum", "hybrid-sac", weights, config, 0.1, 0.2, runs, "a")

    known = [outcome(Weights(1.0, 0.0), 4), outcome(Weights(1.0, 1.0), 3)]
    request = tuning.weights_sweep("Pendulum", "hybrid-sac", {"reward_scale": 3.0}, known)
    assert len(plan(requested(request)).cells) == 8, "three runs are not an outcome yet"
    request = tuning.weights_sweep("Pendulum", "hybrid-sac", {"reward_scale": 1.0}, known)
    assert len(plan(requested(request)).cells) == 9
    everything = [outcome(pair, 4) for pair in tuning.PAIRS["hybrid-sac"]]
    assert tuning.weights_sweep("Pendulum", "hybrid-sac", {"reward_scale": 3.0}, everything) is None


@pytest.mark.parametrize("algorithm", [*tuning.SETTINGS, *tuning.PAIRS])
def test_the_presets_are_what_the_recorded_search_found_best(algorithm: str) -> None:
    rows = read_tuning(RESULTS)
    searched = {row.environment for row in rows if row.algorithm == algorithm}
    assert searched >= set(tuning.SOFT_TASKS)
    for task in searched:
        chosen, reached = preset(algorithm, task), best(rows, task, algorithm)
        assert (chosen.weights, dict(chosen.config)) == (reached.weights, dict(reached.config))


def test_no_seed_of_the_tuning_is_evaluated() -> None:
    assert not set(tuning.SEEDS) & set(range(SEEDS))


def test_the_first_of_the_best_is_chosen() -> None:
    rows = [
        Outcome("Pendulum", "ddpg", Weights(), {"noise": noise}, area, 0.0, 4, "a")
        for noise, area in ((0.2, 0.1), (0.4, 0.3), (0.6, 0.3), (0.8, float("-inf")))
    ]
    assert best(rows, "Pendulum", "ddpg").config == {"noise": 0.4}
    with pytest.raises(ValueError, match="empty"):
        best(rows, "Pendulum", "sac")


def curve(unfinished: dict[str, int], end: float, mean: Sequence[float | None] = ()) -> CurveAnswer:
    """Ten measurements of 800 timesteps each, the last of them `end`."""
    means = list(mean) or [*[0.0] * 9, end]
    return CurveAnswer(
        algorithm="ddpg",
        weights=WeightsAnswer(w1=0.0, w2=0.0),
        config={"noise": 0.2, "critic_decay": 0.0},
        label="ddpg",
        runs=4,
        unfinished=unfinished,
        x=[2000.0 * (k + 1) for k in range(10)],
        mean=means,
        low=means,
        high=means,
        n=[4] * 10,
    )


def outcome_of(one: CurveAnswer) -> Outcome:
    [outcome] = tuning.outcomes(
        CurvesAnswer(
            sweep="a",
            metric="return_mean",
            normalized=True,
            band="std",
            x="timesteps",
            definition="",
            panels=[PanelAnswer(environment="Pendulum", random_return=None, curves=[one])],
        )
    )
    return outcome


def test_area_and_end_of_a_cell() -> None:
    """Of 20,000 timesteps the last tenth holds the last of ten measurements."""
    reached = outcome_of(curve({}, 0.8))
    assert reached.area == pytest.approx(0.08)
    assert (reached.end, reached.runs) == (0.8, 4)


@pytest.mark.parametrize(
    ("status", "decided"), [("diverged", 3 + 1), ("failed", 3), ("cancelled", 3), ("running", 3)]
)
def test_a_cell_with_a_run_that_did_not_end_is_not_chosen(status: str, decided: int) -> None:
    """The other three were far ahead. What diverged would again; anything else may be tried."""
    short, whole = outcome_of(curve({status: 1}, 0.9)), outcome_of(curve({}, 0.1))
    assert short.area == short.end == float("-inf")
    assert short.runs == decided
    assert best([short, whole], "Pendulum", "ddpg") is whole


def test_a_mean_that_is_not_known_everywhere_is_not_chosen() -> None:
    assert outcome_of(curve({}, 0.0, mean=[None, *[1.0] * 9])).area == float("-inf")


def test_the_evaluation_has_every_method_where_it_applies() -> None:
    comparison, critic, soft = (plan(SweepRequest(**request)) for request in evaluation(2))
    assert {cell.timesteps for cell in critic.cells} == {60_000}
    cells = {(cell.algorithm, cell.environment) for cell in comparison.cells}
    assert len(cells) == len(comparison.cells) == 7 + 7 + 6 + 6 + 7
    assert ("mpc", "Acrobot") not in cells
    assert len(soft.cells) == 5 + 5
    for cell in (*comparison.cells, *soft.cells):
        assert cell.timesteps == preset(cell.algorithm, cell.environment).timesteps
    assert set(COMPARISON["environments"]) == {cell.environment for cell in comparison.cells}


def test_a_quick_look_takes_a_share_of_the_timesteps() -> None:
    comparison, *_ = (plan(SweepRequest(**request)) for request in evaluation(1, scale=0.02))
    longest = max(cell.timesteps for cell in comparison.cells)
    assert longest <= 0.02 * 1_488_000 + 800
