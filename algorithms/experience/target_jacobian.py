"""Converts a simulator's derivatives to those that the replay stores.

    dr = dr/dz + dr/ds' ds'/dz,      J = diag(slopes(s')) ds'/dz        z = (seen coordinates, a)

Row i of J belongs to feature i of s', and is the row of its one source coordinate times its slope.
Coordinates that no network sees have no column: the critic has no gradient there to be matched.
"""

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.scaling import Coordinates
from physics.environment import Environment, Linearization
from physics.kernels.compiled import compiled

FloatArray = NDArray[np.float64]


def fold(
    environment: Environment, coordinates: Coordinates, steps: Linearization
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The reward gradients [b, C + m] and feature Jacobians [b, F, C + m] of some steps."""
    next_states = steps.transition.next_state
    columns = coordinates.seen.size + environment.action_size
    slopes = environment.feature_slopes(environment.features(next_states))
    rewards = np.empty((len(next_states), columns), np.float32)
    jacobians = np.empty((len(next_states), environment.feature_size, columns), np.float32)
    fold_rows(
        coordinates.seen,
        environment.feature_sources,
        slopes,
        *steps[1:],
        rewards,
        jacobians,
    )
    return rewards, jacobians


@compiled
def fold_rows(
    seen: NDArray[np.int64],
    sources: NDArray[np.int64],
    slopes: FloatArray,
    state_jacobians: FloatArray,
    action_jacobians: FloatArray,
    reward_state_gradients: FloatArray,
    reward_action_gradients: FloatArray,
    reward_next_state_gradients: FloatArray,
    rewards: NDArray[np.float32],
    jacobians: NDArray[np.float32],
) -> None:
    """Fill `rewards` and `jacobians`, each row by itself, in float64 until the end."""
    coordinates = seen.size
    size = state_jacobians.shape[1]
    for row in range(slopes.shape[0]):
        for column in range(rewards.shape[1]):
            is_action = column >= coordinates
            k = column - coordinates if is_action else seen[column]
            total = reward_action_gradients[row, k] if is_action else reward_state_gradients[row, k]
            for j in range(size):
                entry = action_jacobians[row, j, k] if is_action else state_jacobians[row, j, k]
                total += reward_next_state_gradients[row, j] * entry
            rewards[row, column] = total
            for i in range(sources.size):
                j = sources[i]
                entry = action_jacobians[row, j, k] if is_action else state_jacobians[row, j, k]
                jacobians[row, i, column] = slopes[row, i] * entry
