"""Replay: the transitions of one run, and batches of them as inputs of the networks.

A transition keeps, besides `(features, action, reward, next features, not terminated)`, two things
for learners that match gradients, both with respect to z = (seen coordinates of s, a):

    dr [C + m]        the total derivative of the reward,  dr/dz + dr/ds' ds'/dz
    J  [F, C + m]     d features(s') / dz, the Jacobian already multiplied by the features' slopes

Storing them costs `4 (F + 1)(C + m)` bytes per transition: 1,020 of 1,268 on the cheetah, 48 of 100
on the pendulum. Recomputing them from the states would cost 64 simulator steps per update: 0.92 ms
on the cheetah, whose update takes 0.22 ms, and 0.012 ms on the pendulum (0.17 ms). So they are
stored, and the number of runs that a worker takes at once bounds the memory (`algorithms.memory`).

A checkpoint, however, holds only states and actions (the journal), from which everything here is
recomputed once.

Glossary: `N` capacity, `F` features, `C` seen coordinates, `m` actions, `n` state size, `B` rows.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.networks.layer import Array
from algorithms.networks.scaling import (
    CLIP,
    Coordinates,
    Scaling,
    coordinate_slopes,
    forget_clipped,
    normalise,
)
from algorithms.state import State
from physics.environment import Environment
from physics.kernels.compiled import compiled_fast

REFILL_ROWS = 4096
"""The number of transitions that are recomputed at once from a journal, to limit memory."""


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
    capacity: int, environment: Environment, coordinates: Coordinates, *, linearized: bool
) -> Memory:
    """Memory for `capacity` transitions; the system allocates its pages as they are filled."""
    feature_size, action_size = environment.feature_size, environment.action_size
    columns = coordinates.seen.size + action_size
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
        states: float64 [N, n], the states before the transitions.
        count: how many transitions were added, including those overwritten since.
    """

    def __init__(self, memory: Memory, state_size: int) -> None:
        """Start empty."""
        self.memory = memory
        self.states: NDArray[np.float64] = np.empty((len(memory.rewards), state_size))
        self.count = 0

    @property
    def size(self) -> int:
        """How many transitions it holds."""
        return min(self.count, len(self.memory.rewards))

    @property
    def nbytes(self) -> int:
        """Its size in bytes when it is full."""
        return self.states.nbytes + sum(part.nbytes for part in self.memory)

    def extend(self, transitions: Memory, states: NDArray[np.float64]) -> None:
        """Add transitions; a full replay overwrites its oldest ones."""
        rows = (self.count + np.arange(len(states))) % len(self.memory.rewards)
        for kept, new in zip(self.memory, transitions, strict=True):
            if len(kept):
                kept[rows] = new
        self.states[rows] = states
        self.count += len(states)

    def refill(self, count: int, journal: State, work_out: Callable[[State], Memory]) -> None:
        """Fill the replay with `work_out(journal)`, the latest of `count` transitions."""
        kept = min(len(journal["states"]), len(self.memory.rewards))
        self.count = count - kept
        for start in range(-kept, 0, REFILL_ROWS):
            stop = min(start + REFILL_ROWS, 0) or None
            rows = {name: array[start:stop] for name, array in journal.items()}
            self.extend(work_out(rows), rows["states"])

    def journal(self, start: int) -> State:
        """The journal of the transitions from number `start` on that are still held."""
        oldest = max(start, self.count - self.size)
        rows = np.arange(oldest, self.count) % len(self.memory.rewards)
        return {
            "states": self.states[rows],
            "actions": self.memory.actions[rows],
            "continues": self.memory.continues[rows] > 0,
        }


def check_finite(transitions: Memory) -> None:
    """Refuse transitions with a NaN or an infinity, such as a reward beyond float32.

    Raises:
        NotFiniteQuantityError: with the name of the first such field.
    """
    for name, part in zip(Memory._fields, transitions, strict=True):
        if not np.isfinite(part).all():
            raise NotFiniteQuantityError(name.replace("_", " "))


@compiled_fast
def new_batch(memory: Memory, rows: int) -> Batch:
    """An empty batch of `rows` transitions."""
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
    shift: int,
) -> None:
    """Fill in the derivatives, after `draw`; those of `next_x` are 0 where it is clipped.

    Normalised: rewards by the unit of Q, coordinates and features by their standard deviations.
    Each row gets those of the transition drawn `shift` rows further; 0 for its own.
    """
    features, columns = batch.x.shape[1], batch.reward_gradients.shape[1]
    real = batch.x.dtype.type
    for row in range(indices.size):
        k = indices[row]
        coordinate_slopes(memory.features[k], batch.x[row], coordinates, scaling, batch.slopes[row])
        forget_clipped(memory.features[k], coordinates, batch.slopes[row])
        k = indices[(row + shift) % indices.size]
        for j in range(columns):
            unit = scaling.unit[j] / scaling.value_std
            batch.reward_gradients[row, j] = memory.reward_gradients[k, j] * unit
        for i in range(features):
            inside = abs(batch.next_x[row, i]) < CLIP
            inverse = scaling.inverse[i] if inside else real(0)
            for j in range(columns):
                batch.jacobians[row, i, j] = memory.jacobians[k, i, j] * inverse * scaling.unit[j]


@compiled_fast
def scale_rewards(batch: Batch, c: Any) -> None:
    """Multiply the rewards by c, after `draw`."""
    for row in range(batch.rewards.size):
        batch.rewards[row] *= c


@compiled_fast
def scale_reward_gradients(batch: Batch, c: Any) -> None:
    """Multiply their gradients by c, after `draw_derivatives`."""
    for row in range(batch.rewards.size):
        for j in range(batch.reward_gradients.shape[1]):
            batch.reward_gradients[row, j] *= c
