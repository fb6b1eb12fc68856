"""The reward of running, and its derivatives against differences."""

import numpy as np

from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.reward import Running

RUNNING = Running(control_cost=0.1, bonus=2.0)


def rewards(s: FloatArray, a: FloatArray, following: FloatArray, ends: bool = False) -> FloatArray:
    result = np.empty(len(s))
    RUNNING.fill(0.5, s, a, following, np.full(len(s), ends), result)
    return result


def test_speed_bonus_and_the_cost_of_the_clipped_action() -> None:
    s, a, following = np.array([[1.0, 7.0]]), np.array([[0.5, -3.0]]), np.array([[2.0, 9.0]])
    assert rewards(s, a, following) == [2.0 + 2.0 - 0.1 * 1.25]
    assert rewards(s, a, following, ends=True) == [2.0 - 0.1 * 1.25]


def test_its_gradients() -> None:
    random = generator(0, "running")
    point = [random.uniform(-1.5, 1.5, (50, width)) for width in (4, 3, 4)]
    exact = [np.empty((50, width)) for width in (4, 3, 4)]
    s, a, following = point
    by_s, by_a, by_following = exact
    RUNNING.fill_gradients(0.5, s, a, following, by_s, by_a, by_following)
    for which, gradient in enumerate(exact):
        for i in range(gradient.shape[1]):
            ends = []
            for side in (1e-6, -1e-6):
                moved = [each.copy() for each in point]
                moved[which][:, i] += side
                ends.append(rewards(moved[0], moved[1], moved[2]))
            np.testing.assert_allclose((ends[0] - ends[1]) / 2e-6, gradient[:, i], atol=1e-8)


def test_at_the_bound_the_derivative_is_the_interior_one() -> None:
    by_state, by_action, by_next_state = np.empty((1, 2)), np.empty((1, 2)), np.empty((1, 2))
    zeros = np.zeros((1, 2))
    RUNNING.fill_gradients(
        0.5, zeros, np.array([[1.0, 1.1]]), zeros, by_state, by_action, by_next_state
    )
    assert by_action.tolist() == [[-0.2, 0.0]]
