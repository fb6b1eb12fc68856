"""Replay: what one run has lived through, and batches of it as the networks take them.

A transition keeps, besides `(features, action, reward, next features, not terminated)`, two things
for learners that match gradients, both with respect to z = (seen coordinates of s, a):

    dr [C + m]        the total derivative of the reward,  dr/dz + dr/ds' ds'/dz
    J  [F, C + m]     d features(s') / dz, the Jacobian already multiplied by the features' slopes

Keeping the Jacobian costs `4 (F + 1)(C + m)` bytes a transition (1.1 kB on the cheetah), working it
out again from the state would cost 64 simulator steps an update.

Glossary: `N` capacity, `F` features, `C` seen coordinates, `m` actions, `n` state size, `B` rows.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.layer import Array
from algorithms.scaling import Coordinates, Scaling, coordinate_slopes, normalise
from physics.compiled import compiled_fast


class Memory(NamedTuple):
    """Stored transitions, float32; the last two are empty for learners that match no gradients."""

    features: Array
    """[N, F]"""
    actions: Array
    """[N, m]"""
    rewards: Array
    """[N]"""
    next_features: Array
    """[N, F]"""
    continues: Array
    """[N], 0 where the task ended, else 1."""
    reward_gradients: Array
    """[N, C + m]"""
    jacobians: Array
    """[N, F, C + m]"""


class Batch(NamedTuple):
    """Transitions drawn from a memory, normalised."""

    x: Array
    """[B, F]"""
    actions: Array
    """[B, m]"""
    rewards: Array
    """[B]"""
    next_x: Array
    """[B, F]"""
    continues: Array
    """[B]"""
    slopes: Array
    """[B, F], `d xhat_i / d shat_source(i)`."""
    reward_gradients: Array
    """[B, C + m]"""
    jacobians: Array
    """[B, F, C + m]"""


def empty_memory(
    capacity: int, feature_size: int, action_size: int, columns: int, linearized: bool
) -> Memory:
    """Room for `capacity` transitions; the system hands out its pages as they are filled."""
    kept = capacity if linearized else 0
    shapes = [
        (capacity, feature_size),
        (capacity, action_size),
        (capacity,),
        (capacity, feature_size),
        (capacity,),
        (kept, columns),
        (kept, feature_size, columns),
    ]
    return Memory(*(np.empty(shape, np.float32) for shape in shapes))


class Replay:
    """The latest transitions of one run, in a ring.

    Attributes:
        memory: the transitions; the first `size` are filled.
        states: float64 [N, n], the states they began in.
    """

    def __init__(self, memory: Memory, state_size: int) -> None:
        """Start empty."""
        self.memory = memory
        self.states: NDArray[np.float64] = np.empty((len(memory.rewards), state_size))
        self.size = 0
        self._next = 0

    def extend(self, transitions: Memory, states: NDArray[np.float64]) -> None:
        """Add transitions; once full, in the place of the oldest."""
        capacity = len(self.memory.rewards)
        rows = (self._next + np.arange(len(states))) % capacity
        for kept, new in zip(self.memory, transitions, strict=True):
            if len(kept):
                kept[rows] = new
        self.states[rows] = states
        self._next = (self._next + len(states)) % capacity
        self.size = min(self.size + len(states), capacity)


@compiled_fast
def new_batch(memory: Memory, rows: int) -> Batch:
    """Room for a batch of `rows` transitions."""
    kind = memory.rewards.dtype
    features, actions = memory.features.shape[1], memory.actions.shape[1]
    columns = memory.reward_gradients.shape[1]
    return Batch(
        np.empty((rows, features), kind),
        np.empty((rows, actions), kind),
        np.empty(rows, kind),
        np.empty((rows, features), kind),
        np.empty(rows, kind),
        np.empty((rows, features), kind),
        np.empty((rows, columns), kind),
        np.empty((rows, features, columns), kind),
    )


@compiled_fast
def draw(memory: Memory, indices: NDArray[np.int64], scaling: Scaling, batch: Batch) -> None:
    """Fill the batch with the transitions at `indices [B]`, but for their derivatives."""
    for row in range(indices.size):
        k = indices[row]
        batch.rewards[row] = memory.rewards[k]
        batch.continues[row] = memory.continues[k]
        for i in range(batch.actions.shape[1]):
            batch.actions[row, i] = memory.actions[k, i]
        for i in range(batch.x.shape[1]):
            mean, inverse = scaling.mean[i], scaling.inverse[i]
            batch.x[row, i] = normalise(memory.features[k, i], mean, inverse)
            batch.next_x[row, i] = normalise(memory.next_features[k, i], mean, inverse)


@compiled_fast
def draw_derivatives(
    memory: Memory,
    indices: NDArray[np.int64],
    coordinates: Coordinates,
    scaling: Scaling,
    batch: Batch,
) -> None:
    """Fill in the derivatives, after `draw`; those of `next_x` are 0 where it is clipped.

    Normalised: rewards by the unit of Q, coordinates and features by their standard deviations.
    """
    features, columns = batch.x.shape[1], batch.reward_gradients.shape[1]
    real = batch.x.dtype.type
    for row in range(indices.size):
        k = indices[row]
        coordinate_slopes(memory.features[k], batch.x[row], coordinates, scaling, batch.slopes[row])
        for j in range(columns):
            unit = scaling.unit[j] / scaling.value_std
            batch.reward_gradients[row, j] = memory.reward_gradients[k, j] * unit
        for i in range(features):
            inside = abs(batch.next_x[row, i]) < real(5)
            inverse = scaling.inverse[i] if inside else real(0)
            for j in range(columns):
                batch.jacobians[row, i, j] = memory.jacobians[k, i, j] * inverse * scaling.unit[j]
