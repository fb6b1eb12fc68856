"""The critic of MassPoint as a surface over (s, a), beside the truth (figure 2).

    Q*(s, a) = sum_l gamma^l r(s_l, a_l),   s_0 = s, a_0 = a, then a_l = clip(-s_l / dt, -1, 1)

the discounted return that simulation measures when the first action is a and all others are the
best there are: full speed towards the goal.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.snapshot import Snapshot
from physics.environment import Environment
from physics.mass_point import DT

FloatArray = NDArray[np.float64]

POSITIONS = 41
ACTIONS = 21
REACH = 0.6  # m; an episode starts at -0.5 m


class Surface(NamedTuple):
    """Over p positions and k actions."""

    positions: FloatArray
    """[p]"""
    actions: FloatArray
    """[k]"""
    value: FloatArray
    """[p, k], the critic's Q."""
    truth: FloatArray
    """[p, k], Q*."""
    policy: FloatArray
    """[p], the action that the actor takes."""


def critic_surface(environment: Environment, snapshot: Snapshot, gamma: float) -> Surface:
    """The surface of a snapshot. Raises ValueError where it has no critic."""
    positions = np.linspace(-REACH, REACH, POSITIONS)
    actions = np.linspace(-1.0, 1.0, ACTIONS)
    grid = np.repeat(positions, ACTIONS)[:, None], np.tile(actions, POSITIONS)[:, None]
    shape = POSITIONS, ACTIONS
    policies = snapshot.policies()
    return Surface(
        positions,
        actions,
        snapshot.values(environment.features(grid[0]), grid[1]).reshape(shape),
        best_values(environment, *grid, gamma).reshape(shape),
        np.array([policies.act(environment.features(s[None]))[0, 0] for s in positions[:, None]]),
    )


def best_values(
    environment: Environment, states: FloatArray, actions: FloatArray, gamma: float
) -> FloatArray:
    """Q* [b] of MassPoint's states [b, 1] and actions [b, 1]."""
    values, discount = np.zeros(len(states)), 1.0
    running = np.ones(len(states), np.bool_)
    for _ in range(environment.horizon):
        transition = environment.step(states, actions)
        values += discount * np.where(running, transition.reward, 0.0)
        discount *= gamma
        running &= ~transition.terminated
        if not running.any():
            break
        states = transition.next_state
        actions = np.clip(-states / DT, -1.0, 1.0)
    return values
