"""Scores: one of each run that reached its end, normalised or not, NaN for the others."""

import math

import numpy as np
import pytest

from service.analysis.statistics.score import Score
from service.analysis.statistics.scores import CellScores, sweep_scores
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from tests.service.scored import ByAlgorithm, run_curve
from tests.service.training import random_return

ZERO = {("Pendulum", 1): random_return("Pendulum", -1000.0)}


def best(environment: str) -> float:
    return {"Pendulum": 0.0, "Acrobot": -1.0}[environment]


def scores(*runs: RunCurve, score: Score = "final", normalized: bool = True) -> list[CellScores]:
    return sweep_scores(runs, ByAlgorithm(runs), score, ZERO, best, normalized=normalized)


def test_each_seed_in_their_order() -> None:
    runs = [
        run_curve("ddpg", "Pendulum", 7, [-900, -500]),
        run_curve("ddpg", "Pendulum", 3, [-800]),
    ]
    (cell,) = scores(*runs)
    assert (cell.label, cell.seeds, cell.is_complete) == ("ddpg", (3, 7), True)
    assert cell.values.tolist() == [0.2, 0.5]
    (raw,) = scores(*runs, normalized=False)
    assert raw.values.tolist() == [-800, -500]


@pytest.mark.parametrize(
    ("score", "value"), [("final", 4.0), ("return_history", 4.0), ("area", 2.0)]
)
def test_which_score(score: Score, value: float) -> None:
    """Of 4,000 timesteps the last tenth holds one measurement."""
    run = run_curve("ddpg", "Pendulum", 0, [0, 1, 2, 3, 4], timesteps=4_000)
    (cell,) = scores(run, score=score, normalized=False)
    assert cell.values.tolist() == [value]


@pytest.mark.parametrize("status", sorted(set(RunStatus) - {RunStatus.SUCCEEDED}))
def test_only_what_reached_its_end_counts(status: RunStatus) -> None:
    runs = [
        run_curve("sac", "Pendulum", 0, [-100, -10], status=status),
        run_curve("sac", "Pendulum", 1, [-900, -800]),
    ]
    (cell,) = scores(*runs)
    assert np.isnan(cell.values[0])
    assert cell.values[1] == 0.2
    assert not cell.is_complete
    assert cell.unfinished == {status.value: 1}


def test_what_has_no_finite_value_is_nan() -> None:
    runs = [
        run_curve("ddpg", "Pendulum", 0, []),
        run_curve("ddpg", "Pendulum", 1, [-1.0, math.nan]),
        run_curve("ddpg", "Pendulum", 2, [-1.0, -math.inf]),
        run_curve("ddpg", "Acrobot", 0, [-1.0]),
    ]
    pendulum, acrobot = scores(*runs)
    assert np.isnan(pendulum.values).all()
    assert not pendulum.is_complete
    assert pendulum.unfinished == {}
    assert np.isnan(acrobot.values).all(), "its random return is not known"
    assert scores(*runs, normalized=False)[1].values.tolist() == [-1.0]
