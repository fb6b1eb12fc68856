"""An exact critic agrees with rollouts and with its target; a planted row carries the loss."""

import numpy as np
import pytest

import physics
from algorithms.diagnostics.closed_loop import Gradient, roll_out, value_gradient
from algorithms.diagnostics.critic_gradient import (
    agreement,
    bootstrapped_gradient,
    square_distance,
    top_share,
)
from physics.environment import FloatArray
from physics.tasks.mass_point import DT
from tests.algorithms.diagnostics.test_smoothing import GAIN, linear, states
from tests.algorithms.linear_quadratic import COST, FB, LinearQuadratic

GAMMA = 0.5


def exact_critic(states: FloatArray, actions: FloatArray) -> Gradient:
    """Of the closed loop's discounted return, by its Lyapunov equation."""
    value, step = np.zeros((3, 3)), np.vstack([np.eye(3), GAIN])
    for _ in range(200):
        value = step.T @ (COST + GAMMA * FB.T @ value @ FB) @ step
    by_both = -np.hstack([states, actions]) @ (COST + GAMMA * FB.T @ value @ FB)
    return Gradient(by_both[:, :3], by_both[:, 3:])


def test_the_cosine_is_1_for_an_exact_critic_and_below_for_a_cut_rollout() -> None:
    rollouts = roll_out(LinearQuadratic(), linear, 0.2 * states(), 60)
    own = exact_critic(rollouts.states[0], rollouts.actions[0])
    whole, cut = (value_gradient(rollouts, horizon, GAMMA) for horizon in (60, 1))
    for part in (0, 1):
        assert agreement(own[part], whole[part]).cosine == pytest.approx(1.0, abs=1e-12)
        np.testing.assert_allclose(own[part], whole[part], rtol=1e-9)
        assert agreement(own[part], cut[part]).cosine < 0.999


def test_an_exact_critic_is_its_own_target_at_any_action() -> None:
    starts, actions = 0.2 * states(), np.full((12, 2), 0.3)
    target = bootstrapped_gradient(LinearQuadratic(), linear, exact_critic, starts, actions, GAMMA)
    for own, aim in zip(exact_critic(starts, actions), target, strict=True):
        np.testing.assert_allclose(own, aim, rtol=1e-9)


def test_nothing_is_bootstrapped_beyond_the_end() -> None:
    def still(states: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.zeros((len(states), 1)), np.zeros((len(states), 1, 1))

    def critic(states: FloatArray, actions: FloatArray) -> Gradient:
        return Gradient(np.ones_like(states), np.ones_like(actions))

    starts, actions = np.array([[0.012], [0.5]]), np.full((2, 1), -0.5)
    target = bootstrapped_gradient(physics.make("MassPoint"), still, critic, starts, actions, GAMMA)
    np.testing.assert_allclose(target.by_action, [[0.0], [GAMMA * DT]])
    by_state = -2 * starts / (starts**2 + 1) ** 2 + np.array([[0.0], [GAMMA]])
    np.testing.assert_allclose(target.by_state, by_state)


def test_a_planted_row_carries_its_share() -> None:
    own, aim = np.zeros((200, 2)), np.ones((200, 2))
    assert top_share(square_distance(own, aim)) == pytest.approx(0.01)
    aim[17] = 100.0
    expected = (100.0**2 + 1) / (100.0**2 + 199)
    assert top_share(square_distance(own, aim)) == pytest.approx(expected)
    assert np.isnan(top_share(np.zeros(5)))


def test_rows_without_a_direction_are_left_out() -> None:
    own, aim = np.array([[1.0, 0.0], [0.0, 0.0], [1.0, 1.0]]), np.array([[2.0, 0.0]] * 3)
    assert agreement(own, aim) == pytest.approx(((1 + np.sqrt(0.5)) / 2, 2 / 3))
    cosine, directed = agreement(own, 0 * aim)
    assert np.isnan(cosine)
    assert directed == 0.0


def test_a_direction_has_no_length() -> None:
    own, aim = np.array([[1e250, 1e250], [np.inf, 1.0]]), np.array([[1e-250, 0.0], [1.0, 1.0]])
    assert agreement(own, aim) == pytest.approx((np.sqrt(0.5), 0.5))
