"""Episodes as trajectories: a planner holds one for each run, from start to time limit.

    s_0 a_0 r_0 s_1 a_1 r_1 ... s_T           r_t = r(s_t, a_t, s_{t+1})

An episode that the task ends after step `e - 1` has no reward from `e` on, and its state stays the
same. The whole trajectory is always consistent: each state follows from the one before it.

Glossary: `P` plans, one per run, each independent; `T` steps of an episode; `n`, `m` sizes of
states and actions.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.failing_rows import Failures, call_rows
from physics.environment import Environment
from physics.kernels.compiled import compiled

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Episodes(NamedTuple):
    """One trajectory for each plan."""

    states: Floats
    """[P, T + 1, n]"""
    actions: Floats
    """[P, T, m], within [-1, 1]."""
    rewards: Floats
    """[P, T], 0 from `ends` on."""
    ends: Integers
    """[P], the number of steps after which the task has ended the episode, T if it never does."""


def roll_out(
    environment: Environment, starts: Floats, act: Callable[[Floats], Floats]
) -> tuple[Episodes, Failures]:
    """Whole episodes from the start states [P, n], under a policy: states [P, n] -> [P, m].

    Returns:
        The episodes, void for plans that failed; and the failures.
    """
    plans, horizon = len(starts), environment.horizon
    episodes = Episodes(
        np.empty((plans, horizon + 1, environment.state_size)),
        np.empty((plans, horizon, environment.action_size)),
        np.zeros((plans, horizon)),
        np.full(plans, horizon),
    )
    episodes.states[:, 0] = starts
    failures: Failures = {}
    for t in range(horizon):
        episodes.actions[:, t] = np.clip(act(np.ascontiguousarray(episodes.states[:, t])), -1, 1)
        failures = take_step(environment, episodes, t) | failures
    return episodes, failures


def replay(environment: Environment, episodes: Episodes, start: int) -> Failures:
    """Recompute the states and rewards from step `start` on from the actions.

    Returns:
        The failures of plans; their episodes are void.
    """
    failures: Failures = {}
    episodes.ends[episodes.ends > start] = environment.horizon
    for t in range(start, environment.horizon):
        if (episodes.ends <= t).all():
            episodes.states[:, t + 1 :] = episodes.states[:, t : t + 1]
            episodes.rewards[:, t:] = 0.0
            break
        failures = take_step(environment, episodes, t) | failures
    return failures


def act(
    environment: Environment, model: Environment, episodes: Episodes, now: int, plans: Integers
) -> Failures:
    """Apply the actions of these plans at step `now`, and recompute what follows by the model.

    Returns:
        The failures of plans; their episodes are void.
    """
    own = Episodes._make(part[plans] for part in episodes)
    own.ends[own.ends > now] = environment.horizon
    failures = take_step(environment, own, now)
    failures = replay(model, own, now + 1) | failures
    for part, rows in zip(episodes, own, strict=True):
        part[plans] = rows
    return {int(plans[k]): error for k, error in failures.items()}


def take_step(environment: Environment, episodes: Episodes, t: int) -> Failures:
    """Fill in the results of the states and actions at step t; return the failures of plans."""
    states = np.ascontiguousarray(episodes.states[:, t])
    actions = np.ascontiguousarray(episodes.actions[:, t])
    transition, failures = call_rows(environment.step, states, actions)
    if transition is None:
        episodes.states[:, t + 1] = states
        return failures
    is_over = episodes.ends <= t
    episodes.states[:, t + 1] = np.where(is_over[:, None], states, transition.next_state)
    episodes.rewards[:, t] = np.where(is_over, 0.0, transition.reward)
    episodes.ends[~is_over & transition.terminated] = t + 1
    return failures


@compiled
def window_return(episodes: Episodes, p: int, start: int, stop: int) -> float:
    """The rewards of steps start to stop - 1 of plan p, added in their order."""
    total = 0.0
    for t in range(start, stop):
        total += episodes.rewards[p, t]
    return total
