"""The value of states: the network's values, their targets, and the fit of the network.

    V(s)   = value_mean + value_std v(xhat)
    R_t    = r_t + gamma c_t ((1 - lambda) V(s_{t+1}) + lambda R_{t+1})        c = 1 - terminated
    R_t    = r_t + gamma c_t V(s_{t+1})                   at an episode's and the window's last step

R is TD(lambda)'s return (Sutton, 1988), and R - V(s) the generalised advantage estimate (Schulman
et al., 2016). v is fitted to (R - value_mean) / value_std, by the squared loss.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from algorithms.matching import losses
from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.optimizer import Betas, Learned, clipped_step, corrected_for
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import CLIP, Scaling, normalise
from algorithms.networks.shape import Shape
from physics.kernels.compiled import compiled, compiled_fast

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Integers = NDArray[np.int64]


class Epochs(NamedTuple):
    """The parameters of the fit of a network to a window."""

    order: Integers
    """[epochs, N], the rows of the window in the order of each epoch."""
    rows: int
    """B, the size of each batch; rows left at an epoch's end are not used."""
    done: int
    """Adam's updates before the fit."""
    rate: float
    bound: float
    """Largest norm of a gradient."""
    betas: Betas


class When(Protocol):
    """The values that an update's epochs depend on (algorithms.on_policy.run.Moment)."""

    @property
    def done(self) -> int:
        """Updates done before it."""

    @property
    def draws(self) -> np.random.Generator:
        """The generator of the orders of rows."""


def epochs_of(
    when: When, size: int, count: int, batches: int, rate: float, bound: float, betas: Betas
) -> Epochs:
    """Epochs of batches over a window of `size` rows, each epoch in its own order."""
    order = when.draws.permuted(np.tile(np.arange(size), (count, 1)), axis=1)
    rows = max(size // batches, 1)
    return Epochs(order, rows, when.done * count * (size // rows), rate, bound, betas)


def normalised(returns: Floats, scaling: Scaling) -> NDArray[np.float32]:
    """Returns [T, E] in the unit of values [N]."""
    targets = (returns - np.float64(scaling.value_mean)) / np.float64(scaling.value_std)
    return targets.ravel().astype(np.float32)


@compiled_fast
def see(features: Floats, mean: Array, inverse: Array, x: Array) -> None:
    """Fill the normalised features [T E, F] from [T, E, F]."""
    columns = features.shape[1]
    for row in range(x.shape[0]):
        for i in range(x.shape[1]):
            feature = features[row // columns, row % columns, i]
            x[row, i] = normalise(np.float32(feature), mean[i], inverse[i])


@compiled_fast
def evaluate(
    theta: Array, shape: Shape, scaling: Scaling, features: Floats, values: Floats
) -> Array:
    """Fill V [T, E] of features [T, E, F]; return them normalised [T E, F]."""
    work = network.new_pass(theta, values.size, shape)
    look(Parameters(theta, shape), work, scaling, features, values)
    return work.x


@compiled_fast
def look(v: Parameters, work: Pass, scaling: Scaling, features: Floats, values: Floats) -> None:
    """As `evaluate`, in a pass from which a backward pass may follow."""
    see(features, scaling.mean, scaling.inverse, work.x)
    network.forward(v, work)
    columns = values.shape[1]
    mean, std = np.float64(scaling.value_mean), np.float64(scaling.value_std)
    for row in range(values.size):
        values[row // columns, row % columns] = mean + std * work.out[row, 0]


@compiled_fast
def evaluate_with_gradient(
    theta: Array,
    shape: Shape,
    scaling: Scaling,
    sources: Integers,
    features: Floats,
    slopes: Floats,
    values: Floats,
    gradients: Floats,
) -> None:
    """Fill V [T, E] and dV/ds [T, E, n], the latter 0 on entry.

    `slopes [T, E, F]` are those of features in the coordinates `sources [F]`.
    """
    work = network.new_pass(theta, values.size, shape)
    v = Parameters(theta, shape)
    look(v, work, scaling, features, values)
    work.out_bar[:] = 1
    network.backward_to_input(v, work)
    columns, std = values.shape[1], np.float64(scaling.value_std)
    for row in range(values.size):
        t, e = row // columns, row % columns
        for i in range(sources.size):
            if abs(work.x[row, i]) < CLIP:
                slope = std * scaling.inverse[i] * slopes[t, e, i]
                gradients[t, e, sources[i]] += work.x_bar[row, i] * slope


@compiled
def lambda_returns(
    rewards: Floats,
    next_values: Floats,
    terminated: Bools,
    is_last: Bools,
    gamma: float,
    trace: float,
    result: Floats,
) -> None:
    """Fill R [T, E]; `trace` is lambda."""
    steps, columns = rewards.shape
    for t in range(steps - 1, -1, -1):
        for e in range(columns):
            later = 0.0 if terminated[t, e] else next_values[t, e]
            if not is_last[t, e]:
                later = (1.0 - trace) * later + trace * result[t + 1, e]
            result[t, e] = rewards[t, e] + gamma * later


@compiled_fast
def fit(
    critic: Learned, shape: Shape, x: Array, targets: Array, epochs: Epochs
) -> tuple[float, float, Any]:
    """Fit v to the normalised targets [N] at features x [N, F].

    Returns:
        The mean loss, the mean norm of its gradients, and the squared norm of theta; the fit ends
        at the first that is not finite.
    """
    work = network.new_pass(critic.theta, epochs.rows, shape)
    gradient, batch = np.empty_like(critic.theta), np.empty(epochs.rows, x.dtype)
    v, slope = Parameters(critic.theta, shape), Parameters(gradient, shape)
    loss, norm, size, updates = 0.0, 0.0, x.dtype.type(0), 0
    for epoch in range(epochs.order.shape[0]):
        for first in range(0, x.shape[0] - epochs.rows + 1, epochs.rows):
            gather(x, epochs.order[epoch], first, work.x)
            for row in range(epochs.rows):
                batch[row] = targets[epochs.order[epoch, first + row]]
            network.forward(v, work)
            loss += losses.value_loss(work.out, batch, work.out_bar)
            network.backward(v, work)
            network.gradient(v, work, slope)
            updates += 1
            step = corrected_for(epochs.betas, epochs.rate, epochs.done + updates)
            own, size = clipped_step(critic, gradient, epochs.bound, step, epochs.betas)
            norm += own
            if not (abs(loss) + norm + size < np.inf):
                return loss, norm, size
    return loss / updates, norm / updates, size


@compiled_fast
def gather(rows: Array, order: Integers, first: int, batch: Array) -> None:
    """Copy the rows that an order has from `first` on, as many as the batch [B, F] has."""
    for row in range(batch.shape[0]):
        for i in range(batch.shape[1]):
            batch[row, i] = rows[order[first + row], i]
