"""Kinks: how often a policy's episodes cross from one smooth piece of the task's map to another.

The derivative of a step has no information about the other side of a kink. A task names its pieces
(`Environment.pieces`): sides of clips, turns of angles, contacts that touch, stick or slide.
"""

import numpy as np

from algorithms.diagnostics.closed_loop import Rollouts
from physics.environment import Environment, FloatArray


def kink_share(environment: Environment, rollouts: Rollouts) -> float:
    """The share of steps that lie on another piece than the step before; NaN without such steps."""
    steps, count = rollouts.rewards.shape
    found = environment.pieces(*flat(rollouts)).piece.reshape(steps, count, -1)
    crosses = (found[1:] != found[:-1]).any(axis=2)[rollouts.is_live[1:]]
    return float(crosses.mean()) if crosses.size else float("nan")


def regime_shares(environment: Environment, rollouts: Rollouts) -> dict[str, float]:
    """The share of steps in each regime of the task."""
    regimes = environment.pieces(*flat(rollouts)).regime[rollouts.is_live.ravel()]
    return {name: float(np.mean(regimes == k)) for k, name in enumerate(environment.regimes)}


def flat(rollouts: Rollouts) -> tuple[FloatArray, FloatArray]:
    """The states [T b, n] and actions [T b, m]."""
    states, actions = rollouts.states, rollouts.actions
    return states.reshape(-1, states.shape[2]), actions.reshape(-1, actions.shape[2])
