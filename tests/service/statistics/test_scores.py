"""Scores: the latest value of each run, normalised or not, NaN where there is none."""

import math

import numpy as np

from service.run import RunStatus
from service.statistics.scores import latest_scores
from tests.service.scored import run_curve
from tests.service.training import random_return

ZERO = {("Pendulum", 1): random_return("Pendulum", -1000.0)}


def best(environment: str) -> float:
    return {"Pendulum": 0.0, "Acrobot": -1.0}[environment]


def test_the_latest_value_of_each_seed_in_their_order() -> None:
    runs = [
        run_curve("ddpg", "Pendulum", 7, [-900, -500]),
        run_curve("ddpg", "Pendulum", 3, [-800], status=RunStatus.RUNNING),
    ]
    (cell,) = latest_scores(runs, ZERO, best, normalized=True)
    assert (cell.label, cell.seeds, cell.ended) == ("ddpg", (3, 7), 1)
    assert cell.values.tolist() == [0.2, 0.5]
    (raw,) = latest_scores(runs, ZERO, best, normalized=False)
    assert raw.values.tolist() == [-800, -500]


def test_what_has_no_finite_value_is_nan() -> None:
    runs = [
        run_curve("ddpg", "Pendulum", 0, []),
        run_curve("ddpg", "Pendulum", 1, [-1.0, math.nan]),
        run_curve("ddpg", "Pendulum", 2, [-1.0, -math.inf]),
        run_curve("ddpg", "Acrobot", 0, [-1.0]),
    ]
    pendulum, acrobot = latest_scores(runs, ZERO, best, normalized=True)
    assert np.isnan(pendulum.values).all()
    assert np.isnan(acrobot.values).all(), "its random return is not known"
    assert latest_scores(runs, ZERO, best, normalized=False)[1].values.tolist() == [-1.0]
