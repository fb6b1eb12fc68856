"""Crossings and regimes are counted in the steps that were lived."""

import numpy as np
import pytest

import physics
from algorithms.diagnostics.closed_loop import Rollouts, roll_out
from algorithms.diagnostics.kinks import kink_share, regime_shares
from physics.environment import FloatArray


def turning(states: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.full((len(states), 1), 0.5), np.zeros((len(states), 1, 2))


def rollouts() -> Rollouts:
    """A pendulum that passes below its axle once, into the next turn."""
    return roll_out(physics.make("Pendulum"), turning, np.array([[np.pi - 0.3, 3.0]]), 10)


def test_one_crossing_in_nine_pairs_of_steps() -> None:
    lived = rollouts()
    crossed = int((lived.states[:, 0, 0] < np.pi).sum())
    assert 0 < crossed < 10
    assert kink_share(physics.make("Pendulum"), lived) == pytest.approx(1 / 9)
    shares = regime_shares(physics.make("Pendulum"), lived)
    assert shares == pytest.approx(
        {"free": crossed / 10, "clipped": 0, "wrapped": 1 - crossed / 10}
    )


def test_steps_after_the_end_do_not_count() -> None:
    lived = rollouts()
    shortened = lived._replace(lengths=np.array([1]))
    assert np.isnan(kink_share(physics.make("Pendulum"), shortened))
    assert regime_shares(physics.make("Pendulum"), shortened)["free"] == 1.0
