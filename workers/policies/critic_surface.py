"""The critic of MassPoint as a surface over (s, a), beside the truth (figure 2).

    Q*(s, a) = sum_l gamma^l r(s_l, a_l),   s_0 = s, a_0 = a, then a_l = clip(-s_l / dt, -1, 1)

the discounted return that simulation measures when the first action is a and all others are the
best there are: full speed towards the goal.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms import catalogue
from algorithms.snapshot import Snapshot
from physics.environment import Environment
from physics.tasks.mass_point import DT
from workers.messages.run_spec import RunSpec

FloatArray = NDArray[np.float64]

REACH = 0.6  # m; an episode starts at -0.5 m
POSITIONS = np.linspace(-REACH, REACH, 41)
ACTIONS = np.linspace(-1.0, 1.0, 21)


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
    states, actions = grid()
    policies = snapshot.policies()
    return Surface(
        POSITIONS,
        ACTIONS,
        snapshot.values(environment.features(states), actions).reshape(len(POSITIONS), -1),
        best_surface(environment, gamma),
        np.array([policies.act(environment.features(s[None]))[0, 0] for s in POSITIONS[:, None]]),
    )


def best_surface(environment: Environment, gamma: float) -> FloatArray:
    """Q* [p, k]."""
    return best_values(environment, *grid(), gamma).reshape(len(POSITIONS), -1)


def grid() -> tuple[FloatArray, FloatArray]:
    """States and actions [p k, 1] of every point."""
    return np.repeat(POSITIONS, len(ACTIONS))[:, None], np.tile(ACTIONS, len(POSITIONS))[:, None]


def discount_of(spec: RunSpec) -> float:
    """A run's gamma."""
    gamma: float = catalogue.find(spec.algorithm).config_class()(**spec.config).gamma
    return gamma


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
