"""The cart and pole: momentum, power, symmetry."""

import numpy as np
import pytest

import physics
from physics.environment import FloatArray
from physics.randomness import generator
from physics.tasks.cart_and_pole import CART_MASS, GRAVITY, HALF_LENGTH, POLE_MASS, accelerations

TOTAL_MASS = CART_MASS + POLE_MASS
POLE_MOMENT = POLE_MASS * HALF_LENGTH
MACHINE = (GRAVITY, TOTAL_MASS, POLE_MASS, HALF_LENGTH)


@pytest.fixture
def motion() -> tuple[FloatArray, ...]:
    """speed, theta, omega, force, and the accelerations they give, each [1000]."""
    random = generator(0, "cart and pole")
    speed, theta, omega, force = random.uniform([[-4]], [[4]], (4, 1000)) * [[1], [1], [2], [3]]
    both = np.array([accelerations(MACHINE, *s) for s in zip(theta, omega, force, strict=True)])
    return speed, theta, omega, force, both[:, 0], both[:, 1]


def test_force_is_the_rate_of_horizontal_momentum(motion: tuple[FloatArray, ...]) -> None:
    _, theta, omega, force, push, alpha = motion
    pole = POLE_MOMENT * (alpha * np.cos(theta) - omega**2 * np.sin(theta))
    np.testing.assert_allclose(TOTAL_MASS * push + pole, force, rtol=0, atol=1e-12)


def test_weight_turns_the_pole(motion: tuple[FloatArray, ...]) -> None:
    _, theta, _, _, push, alpha = motion
    turning = 4 / 3 * HALF_LENGTH * alpha + push * np.cos(theta)
    np.testing.assert_allclose(turning, GRAVITY * np.sin(theta), rtol=0, atol=1e-12)


def test_power_is_force_times_speed(motion: tuple[FloatArray, ...]) -> None:
    speed, theta, omega, force, push, alpha = motion
    sin, cos = np.sin(theta), np.cos(theta)
    # d/dt of M v^2/2 + m l v omega cos + 2/3 m l^2 omega^2 + m g l cos
    rate = (
        TOTAL_MASS * speed * push
        + POLE_MOMENT * (push * omega * cos + speed * alpha * cos - speed * omega**2 * sin)
        + 4 / 3 * POLE_MASS * HALF_LENGTH**2 * omega * alpha
        - POLE_MASS * GRAVITY * HALF_LENGTH * omega * sin
    )
    np.testing.assert_allclose(rate, force * speed, rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", ["CartPole", "CartPoleSwingUp"])
def test_a_mirror_changes_signs_alone(name: str) -> None:
    environment = physics.make(name)
    states, actions = environment.sample(generator(0, "mirror"), 1000)
    one, other = (
        environment.differentiate(states, actions),
        environment.differentiate(-states, -actions),
    )
    np.testing.assert_array_equal(one.transition.next_state, -other.transition.next_state)
    np.testing.assert_array_equal(one.transition.reward, other.transition.reward)
    np.testing.assert_array_equal(one.state_jacobian, other.state_jacobian)
    np.testing.assert_array_equal(one.action_jacobian, other.action_jacobian)
