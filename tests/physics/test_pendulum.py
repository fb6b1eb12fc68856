"""Pendulum: Gymnasium's own numbers, and energy."""

from typing import Any

import numpy as np
import pytest
from gymnasium.envs.classic_control.pendulum import PendulumEnv

import physics
from physics.environment import FloatArray
from physics.pendulum import DT, GRAVITY, LENGTH, MASS
from physics.randomness import generator


def test_every_transition_is_gymnasiums() -> None:
    environment = physics.make("Pendulum")
    peer: Any = PendulumEnv()
    states, actions = environment.sample(generator(0, "parity"), 20_000)
    transition = environment.step(states, actions)
    for row in range(len(states)):
        peer.state = states[row]
        _, reward, terminated, _, _ = peer.step(2.0 * actions[row])
        np.testing.assert_allclose(transition.next_state[row], peer.state, rtol=0, atol=1e-12)
        assert transition.reward[row] == pytest.approx(reward, abs=1e-12)
        assert bool(transition.terminated[row]) == terminated


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
