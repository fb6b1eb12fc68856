"""Evaluation: the undiscounted return of one episode of a deterministic policy."""

import numpy as np
from numpy.typing import NDArray

from algorithms.policy import Policies
from physics.environment import Environment

FloatArray = NDArray[np.float64]


def episode_returns(environment: Environment, policies: Policies, starts: FloatArray) -> FloatArray:
    """The returns [K] of one episode of each policy, from the start states [K, n].

    An episode that the task has ended earns nothing more.
    """
    states = starts
    returns = np.zeros(len(starts))
    running = np.ones(len(starts), np.bool_)
    for _ in range(environment.horizon):
        transition = environment.step(states, policies.act(environment.features(states)))
        returns[running] += transition.reward[running]
        running &= ~transition.terminated
        if not running.any():
            break
        states = np.where(running[:, None], transition.next_state, states)
    return returns
