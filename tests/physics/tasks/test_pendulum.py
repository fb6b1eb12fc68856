"""Pendulum: energy, and what its clips do."""

import numpy as np

import physics
from physics.environment import FloatArray
from physics.randomness import generator
from physics.tasks.pendulum import DT, GRAVITY, LENGTH, MASS


def test_energy_changes_by_the_motors_work() -> None:
    """The integrator's error in it is of second order, and no larger than Taylor's remainder:

    |E' - E - u omega' dt| <= dt^2 / 2 (I alpha^2 + m g l / 2 omega'^2)
    """
    environment = physics.make("Pendulum")
    random = generator(0, "energy")
    states = random.uniform([-3.0, -6.0], [3.0, 6.0], (1000, 2))
    actions = random.uniform(-1.0, 1.0, (1000, 1))
    inertia, weight = MASS * LENGTH**2 / 3.0, MASS * GRAVITY * LENGTH / 2.0

    def energy(s: FloatArray) -> FloatArray:
        total: FloatArray = inertia / 2.0 * s[:, 1] ** 2 + weight * np.cos(s[:, 0])
        return total

    following = environment.step(states, actions).next_state
    omega = following[:, 1]
    alpha = (omega - states[:, 1]) / DT
    work = 2.0 * actions[:, 0] * omega * DT
    bound = DT**2 / 2.0 * (inertia * alpha**2 + weight * omega**2)
    assert (np.abs(energy(following) - energy(states) - work) <= bound + 1e-12).all()


def test_no_speed_beyond_eight() -> None:
    environment = physics.make("Pendulum")
    states = np.array([[np.pi / 2, 7.9], [-np.pi / 2, -7.9]])
    linearization = environment.differentiate(states, np.array([[1.0], [-1.0]]))
    np.testing.assert_array_equal(linearization.transition.next_state[:, 1], [8.0, -8.0])
    assert not linearization.state_jacobian[:, 1].any()
    assert not linearization.action_jacobian.any()
    # Only the angle itself goes on counting.
    np.testing.assert_array_equal(linearization.state_jacobian[:, 0], [[1.0, 0.0], [1.0, 0.0]])
