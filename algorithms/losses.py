"""The critic's losses, as residuals and directions for the network's passes.

    value:      1/B sum (Q - Qhat)^2
    gradient:   1/B sum w1 |dQ/da - dQhat/da|^2 + w2 |dQ/ds - dQhat/ds|^2        (L2, Algorithm 1)

everything in normalised units. A gradient loss hands back `v = dL / d(dQ/dz)`; the gradient of L
with respect to the parameters is then that of `v . dQ/dz`, v held (algorithms.network).
"""

from typing import Any

import numpy as np

from algorithms.layer import Array
from algorithms.replay import Batch
from algorithms.scaling import Coordinates
from physics.compiled import compiled_fast

TWO = np.float32(2)


@compiled_fast
def value_loss(q: Array, target: Array, q_bar: Array) -> Any:
    """The value loss of `q [B, 1]`; its derivative goes to `q_bar [B, 1]`."""
    rows = q.shape[0]
    real = q.dtype.type
    share = real(1) / real(rows)
    loss = real(0)
    for row in range(rows):
        residual = q[row, 0] - target[row]
        loss += residual * residual
        q_bar[row, 0] = TWO * share * residual
    return loss * share


@compiled_fast
def critic_gradient(batch: Batch, coordinates: Coordinates, x_bar: Array, result: Array) -> None:
    """`dQ/dz [B, C + m]`, normalised, from the critic's input gradient `x_bar [B, F + m]`."""
    features = batch.x.shape[1]
    seen = coordinates.seen.size
    for row in range(result.shape[0]):
        for j in range(seen):
            result[row, j] = 0
        for i in range(features):
            result[row, coordinates.source[i]] += batch.slopes[row, i] * x_bar[row, i]
        for j in range(result.shape[1] - seen):
            result[row, seen + j] = x_bar[row, features + j]


@compiled_fast
def squared_gradient_loss(
    gradient: Array, target: Array, seen: int, w1: Any, w2: Any, direction: Array
) -> Any:
    """The L2 gradient loss of `gradient [B, C + m]`; its derivative goes to `direction`."""
    rows, columns = gradient.shape
    real = gradient.dtype.type
    share = real(1) / real(rows)
    loss = real(0)
    for row in range(rows):
        for j in range(columns):
            weight = w2 if j < seen else w1
            residual = gradient[row, j] - target[row, j]
            loss += weight * residual * residual
            direction[row, j] = TWO * share * weight * residual
    return loss * share


@compiled_fast
def input_direction(batch: Batch, coordinates: Coordinates, direction: Array, x_dot: Array) -> None:
    """The direction in the critic's inputs [B, F + m] of one in z [B, C + m]."""
    features = batch.x.shape[1]
    seen = coordinates.seen.size
    for row in range(direction.shape[0]):
        for i in range(features):
            x_dot[row, i] = batch.slopes[row, i] * direction[row, coordinates.source[i]]
        for j in range(direction.shape[1] - seen):
            x_dot[row, features + j] = direction[row, seen + j]
