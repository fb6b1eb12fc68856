"""Acrobot and its double pendulum: power, energy, the order of the step, wraps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import physics
from physics.environment import FloatArray
from physics.randomness import generator
from physics.tasks.double_pendulum import D2, DT, WEIGHT1, WEIGHT2, accelerations, advance, inertias


def energy(s: FloatArray) -> FloatArray:
    theta1, theta2, omega1, omega2 = s.T
    cos2 = np.cos(theta2)
    # The inertia matrix is (d1, d2; d2, D2).
    d1, d2 = np.array([inertias(c) for c in cos2]).T
    kinetic = d1 * omega1**2 / 2 + d2 * omega1 * omega2 + D2 * omega2**2 / 2
    total: FloatArray = kinetic - WEIGHT1 * np.cos(theta1) - WEIGHT2 * np.cos(theta1 + theta2)
    return total


def test_power_is_torque_times_the_joints_rate() -> None:
    random = generator(0, "acrobot")
    for s in random.uniform(-3.0, 3.0, (300, 4)):
        torque = random.uniform(-1.0, 1.0)
        rate = np.array([*s[2:], *accelerations((s[0], s[1], s[2], s[3]), torque)])
        width = 1e-4
        gained = energy((s + width * rate)[None]) - energy((s - width * rate)[None])
        assert gained[0] / (2 * width) == pytest.approx(torque * s[3], abs=2e-5)


def test_a_step_follows_the_motion_to_fifth_order() -> None:
    """Slow motion: the step ends where an integration to 1e-12 ends, within dt^5 times a few."""
    random = generator(0, "acrobot")
    for s in random.uniform(-0.5, 0.5, (20, 4)):
        exact = solve_ivp(
            lambda _, y: [y[2], y[3], *accelerations((y[0], y[1], y[2], y[3]), 0.3)],
            (0.0, DT),
            s,
            rtol=1e-12,
            atol=1e-12,
        ).y[:, -1]
        np.testing.assert_allclose(advance(tuple(s), 0.3), exact, rtol=0, atol=4 * DT**5)


def test_energy_drifts_no_more_than_the_integrator_allows() -> None:
    environment = physics.make("Acrobot")
    start = environment.initial_states(range(8))
    state = start
    for _ in range(environment.horizon):
        state = environment.step(state, np.zeros((8, 1))).next_state
    # Small swings: Runge-Kutta of fourth order loses energy, slowly, and never gains it.
    assert (energy(state) <= energy(start)).all()
    assert (energy(start) - energy(state) < 0.05).all()


def test_a_wrapped_angle_keeps_its_derivative() -> None:
    environment = physics.make("Acrobot")
    before = np.array([[3.1, 0.2, 1.0, 0.5]])
    wrapped = environment.differentiate(before, np.zeros((1, 1)))
    assert wrapped.transition.next_state[0, 0] < 0.0
    turned = environment.differentiate(before - [[2 * np.pi, 0.0, 0.0, 0.0]], np.zeros((1, 1)))
    np.testing.assert_allclose(wrapped.state_jacobian, turned.state_jacobian, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        wrapped.transition.next_state, turned.transition.next_state, rtol=0, atol=1e-12
    )


def test_many_turns_are_taken_off_at_once() -> None:
    environment = physics.make("Acrobot")
    far = np.array([[1e6, -1e6, 0.0, 0.0], [1e300, -1e300, 0.0, 0.0]])
    following = environment.step(far, np.zeros((2, 1))).next_state
    assert (np.abs(following[0, :2]) <= np.pi + 1e-9).all()
    assert np.isfinite(following).all()


def test_the_reward_has_no_gradient() -> None:
    environment = physics.make("Acrobot")
    states, actions = environment.sample(generator(0, "acrobot"), 100)
    linearization = environment.differentiate(states, actions)
    assert not environment.reward_is_differentiable
    assert not any(gradient.any() for gradient in linearization[3:])
