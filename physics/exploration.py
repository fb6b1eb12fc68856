"""Exploration: states of a task that policies of every kind reach.

The rollouts follow four kinds of policy, a quarter each: random actions, random bang-bang actions,
bang-bang actions that are held for a while, and constant actions at a bound, as trained policies
have. They continue beyond the horizon, so that slow limits are reached too, and start again when an
episode ends.
"""

from typing import TYPE_CHECKING

import numpy as np

from physics.domain import NotFiniteError
from physics.row_checks import FloatArray

if TYPE_CHECKING:
    from physics.environment import Environment

ROLLOUTS = 64
HORIZONS = 3
HOLDS = 10
"""How often in a horizon a held action changes."""
FARTHEST = 1e4
"""A rollout begins again beyond this many times its start: rounding would hide everything else."""


def explore(
    environment: "Environment",
    generator: np.random.Generator,
    count: int,
    horizon: int | None = None,
) -> tuple[FloatArray, FloatArray]:
    """States [count, n] drawn from all over the rollouts, and actions [count, m], a sixth clipped.

    The rollouts are three horizons long; the horizon is the task's unless given.

    A state whose step is not finite is returned like the others: the caller must handle it.
    """
    horizon = horizon or environment.horizon
    steps, shape = HORIZONS * horizon, (ROLLOUTS, environment.action_size)
    visited = np.empty((steps, ROLLOUTS, environment.state_size))
    states = np.stack([environment.initial_state(generator) for _ in range(ROLLOUTS)])
    farthest = FARTHEST * max(1.0, float(np.abs(states).max(initial=0.0)))
    kind = np.arange(ROLLOUTS)[:, None] % 4
    share = np.array([1.0, 1.0, HOLDS / horizon, 0.0])[kind]  # of steps that change the action
    actions = np.sign(generator.uniform(-1.0, 1.0, shape))
    for step in range(steps):
        visited[step] = states
        random = generator.uniform(-1.0, 1.0, shape)
        changes = generator.uniform(size=(ROLLOUTS, 1)) < share
        actions = np.where(changes, np.where(kind == 0, random, np.sign(random)), actions)
        states = _following(environment, generator, states, actions, farthest)
    rows = generator.integers(steps * ROLLOUTS, size=count)
    chosen = visited.reshape(-1, environment.state_size)[rows]
    return chosen, generator.uniform(-1.2, 1.2, (count, environment.action_size))


def _following(
    environment: "Environment",
    generator: np.random.Generator,
    states: FloatArray,
    actions: FloatArray,
    farthest: float,
) -> FloatArray:
    """The next states; start states where an episode ends, becomes not finite or goes too far."""
    over = np.zeros(len(states), np.bool_)
    try:
        following, _, over = environment.step(states, actions)
    except NotFiniteError as error:
        over[list(error.rows)] = True
        following = states.copy()
        following[~over], _, over[~over] = environment.step(states[~over], actions[~over])
    over |= np.abs(following).max(axis=1) > farthest
    for row in np.flatnonzero(over):
        following[row] = environment.initial_state(generator)
    return following
