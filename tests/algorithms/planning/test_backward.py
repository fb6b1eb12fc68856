"""The backward pass, against Riccati's recursion and against what it promises."""

import numpy as np
import pytest

from algorithms.planning.backward import (
    Gains,
    Regularisation,
    backward,
    lower_level,
    new_gains,
    new_work,
    raise_level,
)
from algorithms.planning.episodes import Episodes
from algorithms.planning.expansion import curved_directions, expand, new_expansion
from physics.environment import FloatArray
from physics.randomness import generator
from tests.algorithms.linear_quadratic import COST, FB, LinearQuadratic
from tests.algorithms.rolled_out import roll_out

TASK = LinearQuadratic()
N, T = TASK.state_size, TASK.horizon


def random_episode(scale: float) -> Episodes:
    draws = generator(1, "random plan")
    return roll_out(
        TASK, TASK.initial_states([0]), lambda s: scale * draws.uniform(-1, 1, (len(s), 2))
    )


def gains_around(episodes: Episodes, level: float) -> Gains:
    expansion, gains = new_expansion(TASK, 1), new_gains(TASK, 1)
    expand(TASK, episodes, np.arange(1), (0, T), curved_directions(TASK), expansion)
    is_possible = np.zeros(1, np.bool_)
    backward(
        np.arange(1), 0, T, episodes, expansion, Regularisation(np.array([level]), np.ones(1)),
        gains, new_work(TASK), is_possible,
    )  # fmt: skip
    assert is_possible[0]
    return gains


def riccati() -> FloatArray:
    """The feedback [T, m, n] of the optimal policy a = G s, without bounds."""
    V = np.zeros((N, N))
    feedback = np.empty((T, TASK.action_size, N))
    for t in reversed(range(T)):
        Q = COST + FB.T @ V @ FB
        feedback[t] = -np.linalg.solve(Q[N:, N:], Q[N:, :N])
        V = Q[:N, :N] + Q[:N, N:] @ feedback[t]
    return feedback


def test_it_equals_the_riccati_solution_where_no_bound_is_near() -> None:
    episodes = random_episode(1e-3)
    episodes.states[:] *= 1e-2  # optimal actions stay far from the bounds
    episodes = roll_out(TASK, episodes.states[:, 0].copy(), lambda s: np.zeros((len(s), 2)))
    gains, optimal = gains_around(episodes, 0.0), riccati()
    np.testing.assert_allclose(gains.feedback[0], optimal, rtol=1e-7, atol=1e-9)
    expected = np.einsum("tij,tj->ti", optimal, episodes.states[0, :-1])
    np.testing.assert_allclose(gains.change[0], expected, rtol=1e-7, atol=1e-11)


@pytest.mark.parametrize("level", [0.0, 0.3, 10.0])
def test_the_expected_improvement_comes_true_where_the_model_is_exact(
    level: float,
) -> None:
    """Whatever the regularisation: the value is that of the unregularised cost."""
    episodes = random_episode(1.0)
    gains = gains_around(episodes, level)
    is_clamped = (np.abs(episodes.actions[0] + gains.change[0]) > 1.0 - 1e-9).sum()
    assert level > 1.0 or is_clamped > 0
    state, total = episodes.states[0, :1].copy(), 0.0
    for t in range(T):
        away = state[0] - episodes.states[0, t]
        a = episodes.actions[0, t] + gains.change[0, t] + gains.feedback[0, t] @ away
        transition = TASK.step(state, a[None])
        # The model knows no bounds but those at the plan's own states.
        assert np.abs(a).max() <= 1.0 + 1e-12
        state, total = transition.next_state, total + transition.reward[0]
    expected = -(gains.slope[0] + gains.bend[0])
    assert expected > 0
    assert total - episodes.rewards[0].sum() == pytest.approx(expected, rel=1e-7)


def test_no_change_leads_out_of_the_box() -> None:
    episodes = random_episode(1.0)
    a = episodes.actions[0] + gains_around(episodes, 0.0).change[0]
    assert np.abs(a).max() <= 1.0 + 1e-15


def test_clamped_actions_do_not_answer_to_the_state() -> None:
    episodes = random_episode(1.0)
    gains = gains_around(episodes, 0.0)
    is_clamped = np.abs(np.abs(episodes.actions[0] + gains.change[0]) - 1.0) < 1e-12
    assert 0 < is_clamped.sum() < is_clamped.size
    assert np.all(gains.feedback[0][is_clamped] == 0.0)
    assert np.all(np.abs(gains.feedback[0][~is_clamped]).max(axis=1) > 0.0)


def test_regularisation_grows_and_shrinks_faster_and_faster() -> None:
    regularisation = Regularisation(np.ones(1), np.ones(1))
    levels = []
    for change in (raise_level, raise_level, lower_level, lower_level, lower_level):
        change(regularisation, 0)
        levels.append(regularisation.level[0])
    np.testing.assert_allclose(levels, 1.6 ** np.array([1.0, 3.0, 2.0, 0.0, -3.0]))


def test_regularisation_ends_at_zero_and_is_refused_beyond_its_largest() -> None:
    regularisation = Regularisation(np.array([1e-6]), np.ones(1))
    lower_level(regularisation, 0)
    assert regularisation.level[0] == 0.0
    assert raise_level(regularisation, 0)
    assert regularisation.level[0] == 1e-6
    regularisation.level[0] = 9e9
    assert not raise_level(regularisation, 0)
