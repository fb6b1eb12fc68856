"""Critic gradient: compares a critic's gradient with that of the value that it estimates.

    rollout      d Q_H^pi(s, a), through simulator and policy, until the task's end or the cut H
    bootstrapped dr + gamma c (dQ/ds' + dQ/da' dpi/ds') J                 the hybrid's own target

A critic can agree with its own target although both are wrong, because the target has the critic's
own errors. The rollout has none; it only lacks the rewards after the cut. The critic of sac
estimates the value of a stochastic policy, entropy included; the rollout follows the policy without
noise.

The hybrid's loss is the squared difference from the bootstrapped target, so each row counts by its
square. If a few rows make up most of it, they dominate a batch's update.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from algorithms.diagnostics.closed_loop import Controller, Gradient, pulled_back
from physics.environment import Environment, FloatArray

CriticGradient = Callable[[FloatArray, FloatArray], Gradient]
"""The gradient of Q at states [b, n] and actions [b, m]."""


def bootstrapped_gradient(
    environment: Environment,
    controller: Controller,
    critic: CriticGradient,
    states: FloatArray,
    actions: FloatArray,
    gamma: float,
) -> Gradient:
    """The gradient of `r + gamma Q(s', pi(s'))` at states [b, n] and actions [b, m]."""
    step, state_jacobian, action_jacobian, by_state, by_action, by_next = environment.differentiate(
        states, actions
    )
    next_actions, policy_jacobian = controller(step.next_state)
    later = critic(step.next_state, next_actions)
    following = later.by_state + pulled_back(later.by_action, policy_jacobian)
    q = by_next + gamma * np.where(step.terminated[:, None], 0.0, following)
    return Gradient(
        by_state + pulled_back(q, state_jacobian), by_action + pulled_back(q, action_jacobian)
    )


class Agreement(NamedTuple):
    """How far two gradients agree."""

    cosine: float
    """The mean over the rows where both have a direction; NaN without such rows."""
    directed: float
    """The share of those rows."""


def agreement(own: FloatArray, aim: FloatArray) -> Agreement:
    """Compare the directions of gradients [b, k], row by row."""
    cosines = (directions(own) * directions(aim)).sum(axis=1)
    directed = np.isfinite(cosines)
    mean = float(cosines[directed].mean()) if directed.any() else float("nan")
    return Agreement(mean, float(directed.mean()))


def directions(rows: FloatArray) -> FloatArray:
    """Rows [b, k] of length 1, whatever their lengths; NaN for those that are 0 or not finite."""
    with np.errstate(invalid="ignore", divide="ignore"):
        scaled = rows / np.abs(rows).max(axis=1, keepdims=True)
        unit: FloatArray = scaled / np.linalg.norm(scaled, axis=1, keepdims=True)
    return unit


def top_share(losses: FloatArray, share: float = 0.01) -> float:
    """The fraction of the sum that the largest `share` of losses [b] makes up; NaN if it is 0.

    At least one loss is included.
    """
    count = max(1, round(share * len(losses)))
    total = losses.sum()
    return float(np.sort(losses)[-count:].sum() / total) if total > 0 else float("nan")


def square_distance(own: FloatArray, aim: FloatArray) -> FloatArray:
    """`|own - aim|^2` [b] of rows [b, k]."""
    distance: FloatArray = np.square(own - aim).sum(axis=1)
    return distance
