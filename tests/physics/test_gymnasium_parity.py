"""The classic tasks' transitions are Gymnasium's own, for the same state and action."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gymnasium.envs.classic_control import continuous_mountain_car
from gymnasium.envs.classic_control.acrobot import AcrobotEnv
from gymnasium.envs.classic_control.cartpole import CartPoleEnv
from gymnasium.envs.classic_control.pendulum import PendulumEnv

import physics
from physics.environment import Environment, FloatArray
from physics.randomness import generator

COUNT = 100_000
TOLERANCE = 1e-12

PeerStep = Callable[[float], tuple[Any, float, bool, bool, dict[str, Any]]]


def peer_transitions(
    peer: Any, step: PeerStep, states: FloatArray, actions: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    next_states, rewards = np.empty_like(states), np.empty(len(states))
    terminated = np.empty(len(states))
    for row in range(len(states)):
        peer.state = states[row].copy()
        _, rewards[row], terminated[row], _, _ = step(float(actions[row, 0]))
        next_states[row] = peer.state
    return next_states, rewards, terminated


def pairs(environment: Environment) -> tuple[FloatArray, FloatArray]:
    return environment.sample(generator(0, "parity"), COUNT)


def assert_same_motion(
    environment: Environment, peer: Any, step: PeerStep
) -> tuple[FloatArray, FloatArray]:
    states, actions = pairs(environment)
    next_states, rewards, terminated = peer_transitions(peer, step, states, actions)
    transition = environment.step(states, actions)
    np.testing.assert_allclose(transition.next_state, next_states, rtol=0, atol=TOLERANCE)
    np.testing.assert_array_equal(transition.terminated, terminated)
    return transition.reward, rewards


def test_cart_pole() -> None:
    peer: Any = CartPoleEnv()

    def step(a: float) -> Any:
        # The peer pushes with one force, left or right: give it ours.
        peer.force_mag, peer.steps_beyond_terminated = 10.0 * min(max(a, -1.0), 1.0), None
        return peer.step(1)

    environment = physics.make("CartPole")
    assert_same_motion(environment, peer, step)
    terminated = environment.step(*pairs(environment)).terminated
    assert 0.1 < terminated.mean() < 0.9


def test_cart_pole_as_the_discrete_peer_pushes() -> None:
    environment = physics.make("CartPole")
    peer: Any = CartPoleEnv()
    states = pairs(environment)[0][:1000]
    for action, side in ((1.0, 1), (-1.0, 0)):
        following = environment.step(states, np.full((1000, 1), action)).next_state
        for row in range(1000):
            peer.state, peer.steps_beyond_terminated = states[row], None
            peer.step(side)
            np.testing.assert_allclose(following[row], peer.state, rtol=0, atol=TOLERANCE)


def test_pendulum_with_its_reward() -> None:
    peer: Any = PendulumEnv()

    def step(a: float) -> Any:
        return peer.step([2.0 * a])

    ours, theirs = assert_same_motion(physics.make("Pendulum"), peer, step)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=TOLERANCE)


def test_mountain_car(monkeypatch: pytest.MonkeyPatch) -> None:
    # The peer stores its state as float32, which would hide all but 7 digits.
    wide = SimpleNamespace(array=np.array, float32=np.float64)
    peer: Any = continuous_mountain_car.Continuous_MountainCarEnv()
    monkeypatch.setattr(continuous_mountain_car, "np", wide)

    def step(a: float) -> Any:
        return peer.step([a])

    environment = physics.make("MountainCar")
    assert_same_motion(environment, peer, step)
    transition = environment.step(*pairs(environment))
    assert transition.terminated.any()
    assert (transition.next_state[:, 0] == -1.2).any()
    assert (transition.next_state[:, 0] == 0.6).any()


def test_acrobot_with_its_reward() -> None:
    peer: Any = AcrobotEnv()

    def step(a: float) -> Any:
        peer.AVAIL_TORQUE = [min(max(a, -1.0), 1.0)]
        return peer.step(0)

    ours, theirs = assert_same_motion(physics.make("Acrobot"), peer, step)
    np.testing.assert_array_equal(ours, theirs)
    assert 0.05 < (ours == 0.0).mean() < 0.95
