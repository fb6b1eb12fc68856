"""The critic's losses, as residuals and directions for the network's passes.

    value:      1/B sum (Q - Qhat)^2
    gradient:   1/B sum w1 |dQ/da - dQhat/da|^2 + w2 |dQ/ds - dQhat/ds|^2        (L2, Algorithm 1)
                1/B sum w1 (1 - cos(dQ/da, dQhat/da)) + w2 (1 - cos(dQ/ds, dQhat/ds))   (equation 3)
                1/B sum c (w1 rho^2 h(|dQ/da - dQhat/da| / rho) + w2 (1 - cos(dQ/ds, dQhat/ds)))
                                                                                          (robust)

everything in normalised units. A gradient loss returns `v = dL / d(dQ/dz)`; the gradient of L with
respect to the parameters is then that of `v . dQ/dz` for constant v (algorithms.networks.network).

The robust loss is our own. The action's gradient, which the actor climbs, is matched in its size,
with a bound on the influence of one row (pseudo-Huber, Charbonnier et al., 1997):

    h(x) = 2 (sqrt(1 + x^2) - 1),     rho = mean over the batch of |dQhat/da|

which is the L2 loss for residuals below rho and grows like 2 rho |residual| beyond. The state's
gradient, which recurs through the Jacobians, is matched in its direction alone. Rows at which the
task ended, c = 0, are left out: their target has only the reward's gradient.

The cosine of two short vectors fades to 0, and its derivative stays below 1 / EPSILON:

    cos(g, t) = g . t / (|g|' |t|'),    |x|' = sqrt(|x|^2 + EPSILON^2)

so that a vanishing gradient, as all are on Acrobot at first, has no effect. The paper's equation 3
has no EPSILON.

No loop both sums and stores: whether such a loop is vectorised is decided as it runs, by the
distance between its arrays, and a vectorised sum has other bits.
"""

from typing import Any, NamedTuple

import numpy as np

from algorithms.experience.replay import Batch
from algorithms.networks.layer import Array
from algorithms.networks.scaling import Coordinates
from physics.kernels.compiled import compiled_fast

ONE, TWO = np.float32(1), np.float32(2)
EPSILON = np.float32(1e-3)
L2, COSINE, ROBUST = range(3)


class Matching(NamedTuple):
    """The settings of gradient matching."""

    w1: np.float32
    """Weight of the action gradient."""
    w2: np.float32
    """Weight of the state gradient."""
    loss: int
    """L2 (Algorithm 1), COSINE (equation 3) or ROBUST."""
    shift: int
    """The shift of the rows from which derivatives are taken: 0, or 1 for a placebo."""
    is_aimed: bool
    """Whether there is a target; False for a placebo whose target is 0."""
    every: int
    """One of this many updates matches gradients; the others only fit values."""


def matching_of(
    weights: tuple[float, float], loss: int, placebo: str = "none", every: int = 1
) -> Matching:
    """Matching with the weights (w1, w2), in one of `every` updates.

    A placebo has the same cost, but no information. With "shuffled", each transition gets the
    derivatives of another one; with "untargeted", the target is 0, so that the gradient is only
    kept small.
    """
    w1, w2 = np.float32(weights[0]), np.float32(weights[1])
    return Matching(w1, w2, loss, int(placebo == "shuffled"), placebo != "untargeted", every)


@compiled_fast
def due(matching: Matching, done: int) -> Matching:
    """The matching of the update after `done` others: the given one, or none."""
    if done % matching.every == 0:
        return matching
    none = np.float32(0)
    return Matching(none, none, matching.loss, matching.shift, matching.is_aimed, matching.every)


@compiled_fast
def is_matched(matching: Matching) -> Any:
    """Whether there is a gradient loss at all."""
    return matching.w1 > 0 or matching.w2 > 0


@compiled_fast
def blind(matching: Matching, target: Array) -> None:
    """Set the target of the gradients to 0 for a placebo without target."""
    if not matching.is_aimed:
        target[:] = 0


@compiled_fast
def value_loss(q: Array, target: Array, q_bar: Array) -> Any:
    """Return the value loss of `q [B, 1]`; its derivative goes to `q_bar [B, 1]`."""
    rows = q.shape[0]
    real = q.dtype.type
    share = real(1) / real(rows)
    for row in range(rows):
        q_bar[row, 0] = TWO * share * (q[row, 0] - target[row])
    loss = real(0)
    for row in range(rows):
        residual = q[row, 0] - target[row]
        loss += residual * residual
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
def gradient_loss(
    gradient: Array,
    target: Array,
    continues: Array,
    seen: int,
    matching: Matching,
    direction: Array,
) -> Any:
    """Return the gradient loss of `gradient [B, C + m]`; its derivative goes to `direction`."""
    w1, w2, end = matching.w1, matching.w2, gradient.shape[1]
    if matching.loss == L2:
        actions = squared_loss(gradient, target, seen, end, w1, direction)
        return actions + squared_loss(gradient, target, 0, seen, w2, direction)
    every = np.ones_like(continues)
    if matching.loss == COSINE:
        actions = cosine_loss(gradient, target, every, seen, end, w1, direction)
        return actions + cosine_loss(gradient, target, every, 0, seen, w2, direction)
    actions = bounded_loss(gradient, target, continues, seen, end, w1, direction)
    return actions + cosine_loss(gradient, target, continues, 0, seen, w2, direction)


@compiled_fast
def squared_loss(
    gradient: Array, target: Array, first: int, end: int, weight: Any, direction: Array
) -> Any:
    """The L2 loss of columns `first` to `end`."""
    rows = gradient.shape[0]
    real = gradient.dtype.type
    share = weight / real(rows)
    for row in range(rows):
        for j in range(first, end):
            direction[row, j] = TWO * share * (gradient[row, j] - target[row, j])
    loss = real(0)
    for row in range(rows):
        for j in range(first, end):
            residual = gradient[row, j] - target[row, j]
            loss += residual * residual
    return loss * share


@compiled_fast
def bounded_loss(
    gradient: Array,
    target: Array,
    rows_in: Array,
    first: int,
    end: int,
    weight: Any,
    direction: Array,
) -> Any:
    """The pseudo-Huber loss of columns `first` to `end`, over the rows where `rows_in [B]` is 1.

    `dL/dg = 2 w1 residual / sqrt(1 + |residual|^2 / rho^2)`.
    """
    rows = gradient.shape[0]
    real = gradient.dtype.type
    share = weight / real(rows)
    rho = mean_norm(target, rows_in, first, end)
    loss = real(0)
    for row in range(rows):
        square = real(0)
        for j in range(first, end):
            square += (gradient[row, j] - target[row, j]) ** 2
        stretch = np.sqrt(ONE + square / (rho * rho))
        loss += rows_in[row] * TWO * rho * rho * (stretch - ONE)
        pull = rows_in[row] * TWO * share / stretch
        for j in range(first, end):
            direction[row, j] = pull * (gradient[row, j] - target[row, j])
    return loss * share


@compiled_fast
def mean_norm(vectors: Array, rows_in: Array, first: int, end: int) -> Any:
    """The mean of `|v|` over the rows where `rows_in` is 1, no shorter than EPSILON."""
    total, count = vectors.dtype.type(0), vectors.dtype.type(0)
    for row in range(vectors.shape[0]):
        square = vectors.dtype.type(0)
        for j in range(first, end):
            square += vectors[row, j] * vectors[row, j]
        total += rows_in[row] * np.sqrt(square)
        count += rows_in[row]
    return max(total / max(count, ONE), EPSILON)


@compiled_fast
def cosine_loss(
    gradient: Array,
    target: Array,
    rows_in: Array,
    first: int,
    end: int,
    weight: Any,
    direction: Array,
) -> Any:
    """The cosine loss of columns `first` to `end`: `dcos/dg = (t / |t|' - cos g / |g|') / |g|'`.

    It covers the rows where `rows_in [B]` is 1.
    """
    rows = gradient.shape[0]
    real = gradient.dtype.type
    share = weight / real(rows)
    loss = real(0)
    for row in range(rows):
        product, own, aim = real(0), EPSILON * EPSILON, EPSILON * EPSILON
        for j in range(first, end):
            product += gradient[row, j] * target[row, j]
            own += gradient[row, j] * gradient[row, j]
            aim += target[row, j] * target[row, j]
        own, aim = ONE / np.sqrt(own), ONE / np.sqrt(aim)
        cosine = product * own * aim
        loss += rows_in[row] * (ONE - cosine)
        for j in range(first, end):
            along = target[row, j] * aim - cosine * gradient[row, j] * own
            direction[row, j] = -share * rows_in[row] * own * along
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
