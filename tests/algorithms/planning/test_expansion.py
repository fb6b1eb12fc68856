"""The expansion of dynamics and cost, against differences, by hand and in closed form."""

import numpy as np
import pytest

import physics
from algorithms.planning.expansion import Expansion, curved_directions, expand, new_expansion
from physics.environment import Environment, FloatArray
from physics.randomness import generator
from tests.algorithms.linear_quadratic import COST, FB, LinearQuadratic
from tests.algorithms.rolled_out import roll_out

TASKS = ["Pendulum", "CartPole", "CartPoleSwingUp", "MountainCar", "MassPoint"]


def expansion_of(environment: Environment, plans: int = 2) -> tuple[Expansion, FloatArray]:
    """Around an episode of random actions; also its x [P, T, n + m]."""
    draws = generator(3, "random plan")
    episodes = roll_out(
        environment,
        environment.initial_states(range(plans)),
        lambda states: draws.uniform(-1, 1, (len(states), environment.action_size)),
    )
    expansion = new_expansion(environment, plans)
    directions = curved_directions(environment)
    expand(environment, episodes, np.arange(plans), (0, environment.horizon), directions, expansion)
    return expansion, np.concatenate([episodes.states[:, :-1], episodes.actions], axis=2)


def test_it_is_exact_where_the_task_is_linear_quadratic() -> None:
    expansion, x = expansion_of(LinearQuadratic())
    assert np.array_equal(expansion.jacobian, np.broadcast_to(FB, expansion.jacobian.shape))
    np.testing.assert_allclose(expansion.gradient, x @ COST, atol=1e-12)
    everywhere = np.broadcast_to(COST, expansion.curvature.shape)
    np.testing.assert_allclose(expansion.curvature, everywhere, atol=1e-9)


@pytest.mark.parametrize("name", TASKS)
def test_the_gradient_is_that_of_the_cost_of_a_step(name: str) -> None:
    environment = physics.make(name)
    expansion, x = expansion_of(environment, plans=1)
    n, h = environment.state_size, 1e-6
    for i in range(x.shape[2]):
        step = h * (np.arange(x.shape[2]) == i)
        forth, back = (
            environment.step(np.ascontiguousarray(y[:, :n]), np.ascontiguousarray(y[:, n:])).reward
            for y in (x[0] + step, x[0] - step)
        )
        difference = -(forth - back) / (2 * h)
        is_smooth = np.abs(difference) < 1e3  # the turn of Pendulum's angle
        np.testing.assert_allclose(
            expansion.gradient[0, is_smooth, i], difference[is_smooth], rtol=1e-5, atol=1e-7
        )


def test_the_curvature_is_gauss_newton_where_the_cost_is_convex() -> None:
    environment = physics.make("CartPoleSwingUp")
    expansion, x = expansion_of(environment, plans=1)
    n = environment.state_size
    states, actions = x[0, :, :n].copy(), x[0, :, n:].copy()
    states[:, 2] += np.pi  # upright, where the reward is concave
    theta = environment.step(states, actions).next_state[:, 2]
    episodes = roll_out(environment, states[:1], lambda s: np.zeros((len(s), 1)))
    episodes.states[0, :-1], episodes.actions[0] = states, actions
    every = (0, environment.horizon)
    expand(environment, episodes, np.arange(1), every, curved_directions(environment), expansion)
    J = expansion.jacobian[0]
    bends = np.stack([np.full(len(theta), 0.1 / 2.4**2), np.cos(theta) / 2], axis=1)
    expected = np.einsum("tk,tki,tkj->tij", bends, J[:, [0, 2]], J[:, [0, 2]])
    is_convex = np.cos(theta) > 0
    assert is_convex.sum() > 100
    np.testing.assert_allclose(
        expansion.curvature[0, is_convex], expected[is_convex], rtol=1e-3, atol=1e-6
    )


@pytest.mark.parametrize("name", TASKS)
def test_the_curvature_is_semidefinite(name: str) -> None:
    curvature = expansion_of(physics.make(name))[0].curvature
    assert np.array_equal(curvature, np.swapaxes(curvature, 2, 3))
    lowest = np.linalg.eigvalsh(curvature)[..., 0]
    assert lowest.min() >= -1e-12 * np.abs(curvature).max()


def test_only_curved_directions_are_differenced() -> None:
    assert curved_directions(physics.make("MassPoint")).tolist() == [0]
    assert curved_directions(LinearQuadratic()).tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("bound", [-1.0, 1.0])
def test_an_action_on_its_bound_has_the_curvature_of_the_inside(bound: float) -> None:
    environment = physics.make("Pendulum")
    episodes = roll_out(environment, np.zeros((1, 2)), lambda s: np.full((len(s), 1), bound))
    expansion = new_expansion(environment, 1)
    expand(environment, episodes, np.arange(1), (0, 5), curved_directions(environment), expansion)
    np.testing.assert_allclose(expansion.curvature[0, :5, 2, 2], 0.008, rtol=1e-6)
