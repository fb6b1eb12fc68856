"""The gradient of a closed loop against differences, and after an end of the task."""

import numpy as np
import pytest

import physics
from algorithms.diagnostics.closed_loop import roll_out, value_gradient
from physics.environment import FloatArray
from physics.randomness import generator
from tests.algorithms.diagnostics.test_smoothing import linear, states
from tests.algorithms.linear_quadratic import LinearQuadratic

GAMMA = 0.9


def earned(starts: FloatArray, first: FloatArray, horizon: int) -> FloatArray:
    """The discounted return [b] with `first` added to the first action."""
    noise = np.concatenate([first[None], np.zeros((horizon - 1, *first.shape))])
    rewards = roll_out(LinearQuadratic(), linear, starts, horizon, noise).rewards
    return GAMMA ** np.arange(horizon) @ rewards


@pytest.mark.parametrize("horizon", [1, 2, 7])
def test_the_gradient_is_the_slope_of_the_return(horizon: int) -> None:
    starts, zero = 0.5 * states(), np.zeros((12, 2))
    gradient = value_gradient(roll_out(LinearQuadratic(), linear, starts, 9), horizon, GAMMA)
    _, policy_jacobian = linear(starts)
    random = generator(0, "directions")
    along_a, along_s = random.standard_normal((12, 2)), random.standard_normal((12, 3))
    h = 1e-4
    by_action = (earned(starts, h * along_a, horizon) - earned(starts, -h * along_a, horizon)) / (
        2 * h
    )
    np.testing.assert_allclose((gradient.by_action * along_a).sum(axis=1), by_action, atol=1e-8)
    ahead, behind = (earned(starts + h * way * along_s, zero, horizon) for way in (1, -1))
    total = gradient.by_state + np.einsum("bm,bmn->bn", gradient.by_action, policy_jacobian)
    np.testing.assert_allclose((total * along_s).sum(axis=1), (ahead - behind) / (2 * h), atol=1e-8)


def test_nothing_is_earned_after_the_end() -> None:
    def forward(states: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.full((len(states), 1), 0.5), np.zeros((len(states), 1, 1))

    rollouts = roll_out(physics.make("MassPoint"), forward, np.array([[-0.022], [-0.5]]), 8)
    assert rollouts.lengths.tolist() == [3, 8]
    assert (rollouts.rewards[:3] < 0).all()
    assert not rollouts.rewards[3:, 0].any()
    ended, cut = (value_gradient(rollouts, horizon).by_action for horizon in (8, 3))
    assert ended[0] == cut[0]
    assert ended[1] != cut[1]
