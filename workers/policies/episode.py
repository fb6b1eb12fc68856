"""Episode: what a policy does from a start state until the task or the time limit ends it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.policy import Policies
from physics.environment import Environment

FloatArray = NDArray[np.float64]


class Episode(NamedTuple):
    """T steps of one policy."""

    states: FloatArray
    """[T + 1, n]"""
    actions: FloatArray
    """[T, m], as the task took them: within the box."""
    rewards: FloatArray
    """[T]"""
    terminated: bool
    """Whether the task ended it, and not the time limit."""


def play(environment: Environment, policies: Policies, start: FloatArray) -> Episode:
    """Play one episode of a single policy from a start state [n].

    Raises:
        ValueError: for a start outside the task's domain.
        UnsolvedStepError: as `Environment.step`.
    """
    states = [start]
    actions: list[FloatArray] = []
    rewards: list[float] = []
    terminated = False
    while len(actions) < environment.horizon and not terminated:
        state = states[-1][None]
        action = policies.act(environment.features(state))
        transition = environment.step(state, action)
        states.append(transition.next_state[0])
        actions.append(np.clip(action[0], -1.0, 1.0))
        rewards.append(float(transition.reward[0]))
        terminated = bool(transition.terminated[0])
    return Episode(np.array(states), np.array(actions), np.array(rewards), terminated)
