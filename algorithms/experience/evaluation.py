"""Evaluation: the undiscounted return of one episode of a deterministic policy."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.failing_rows import Failures, call_rows
from algorithms.networks.policy import Policies
from physics.environment import Environment

FloatArray = NDArray[np.float64]


class Played(NamedTuple):
    """An episode of each policy."""

    returns: FloatArray
    """[K], undiscounted."""
    steps: NDArray[np.int64]
    """[K]"""


def episode_returns(
    environment: Environment, policies: Policies, starts: FloatArray
) -> tuple[FloatArray, Failures]:
    """The returns [K] of one episode of each policy, from the start states [K, n].

    After the task has ended an episode, its rewards are 0.

    Returns:
        The returns, void for policies that failed; and the failures.
    """
    played, failures = play(environment, policies, starts)
    return played.returns, failures


def play(
    environment: Environment, policies: Policies, starts: FloatArray
) -> tuple[Played, Failures]:
    """As `episode_returns`, with the number of steps of each episode."""
    states = starts
    returns, steps = np.zeros(len(starts)), np.zeros(len(starts), np.int64)
    running = np.ones(len(starts), np.bool_)
    failures: Failures = {}
    for _ in range(environment.horizon):
        actions = policies.act(environment.features(states))
        transition, failed = call_rows(environment.step, states, actions)
        failures = failed | failures
        if transition is None:
            break
        with np.errstate(over="ignore"):
            returns[running] += transition.reward[running]
        steps += running
        running &= ~transition.terminated
        if not running.any():
            break
        states = np.where(running[:, None], transition.next_state, states)
    for k in np.flatnonzero(~np.isfinite(returns)):
        failures.setdefault(int(k), NotFiniteQuantityError("return"))
    return Played(returns, steps), failures
