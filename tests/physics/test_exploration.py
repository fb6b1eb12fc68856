"""Exploration goes where trained policies go, and beyond the horizon."""

import numpy as np
import torch

import physics
from physics.exploration import explore
from physics.randomness import generator
from tests.physics.small_tasks import LogOfNegative, Plain


def test_constant_actions_are_among_the_policies() -> None:
    """A mass pushed at 0.1 for 150 steps: random actions come to 2, constant ones to 16."""
    states, actions = explore(Plain(), generator(0, "explore"), 2000)
    assert states[:, 1].max() > 14.0
    assert states[:, 1].min() < -14.0
    assert (np.abs(states[:, 1]) < 1.0).mean() > 0.2
    assert 0.1 < (np.abs(actions) > 1.0).mean() < 0.25
    assert np.abs(actions).max() <= 1.2


def test_it_is_a_function_of_its_generator() -> None:
    task = physics.make("MassPoint")
    one, other = (explore(task, generator(5, "explore"), 100) for _ in range(2))
    np.testing.assert_array_equal(one[0], other[0])
    np.testing.assert_array_equal(one[1], other[1])


def test_states_before_a_step_that_leaves_the_numbers_are_kept() -> None:
    states, _ = explore(LogOfNegative(), generator(0, "explore"), 500)
    assert np.isfinite(states).all()
    assert (states[:, 0] + 0.1 * states[:, 1] < 0.0).any()


def test_what_runs_away_begins_anew() -> None:
    class Unstable(Plain):
        def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
            return 2.0 * state + 0.1 * action

    states, _ = explore(Unstable(), generator(0, "explore"), 500)
    assert 100.0 < np.abs(states).max() <= 1e4
