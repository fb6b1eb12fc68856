"""The compiled heart of PPO: all epochs of one run's actor over one window.

    ratio = exp(log p(u) - log p_old(u)),    u = mu_old(s) + sigma_old e
    log p(u) = sum over actions of  -((u - mu) / sigma)^2 / 2 - log sigma            + a constant
    L = -1/B sum min(ratio A, clip(ratio, 1 - bound, 1 + bound) A)

with the advantages A of a batch normalised to mean 0 and standard deviation 1. Where the lesser of
the two is the clipped one, L has no gradient; elsewhere, per row and action, with z = (u - mu) /
sigma,

    dL/dmu = -A ratio z / (sigma B),    dL/dlog sigma = -A ratio (z^2 - 1) / B
"""

from typing import Any, NamedTuple

import numpy as np

from algorithms.networks import network
from algorithms.networks.gaussian import spread
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.optimizer import Learned, clipped_step, corrected_for
from algorithms.networks.parameters import Parameters
from algorithms.networks.shape import Shape
from algorithms.on_policy.actor import is_free
from algorithms.on_policy.values import Epochs, gather
from physics.kernels.compiled import compiled_fast

HALF, ONE, SMALL = np.float32(0.5), np.float32(1), np.float32(1e-8)


class Rows(NamedTuple):
    """The data that the actor learns from, [N, ...], or a batch of it."""

    x: Array
    """[N, F], normalised features."""
    noise: Array
    """[N, m], u - mu_old."""
    means: Array
    """[N, m], mu_old."""
    advantages: Array
    """[N], in the unit of values."""


class Seen(NamedTuple):
    """The report of the epochs."""

    gradient_norm: Any
    """Mean of the gradients' norms."""
    clipped: Any
    """Share of rows without a gradient."""
    divergence: Any
    """Mean of  ratio - 1 - log ratio, which estimates the distance of the policies."""
    size: Any
    """Squared norm of the parameters."""


@compiled_fast
def improve(
    actor: Learned, shape: Shape, x: Array, noise: Array, advantages: Array, bound: Any, how: Epochs
) -> Seen:
    """Step the actor down L on each batch of each epoch; stop if a number is not finite."""
    theta, m = actor.theta, noise.shape[1]
    pi = Parameters(theta, shape)
    old_spread = np.empty(m, theta.dtype)
    for i in range(m):
        old_spread[i] = spread(theta[theta.size - m + i])
    rows = Rows(x, noise, means_of(pi, x), advantages)
    work, batch = network.new_pass(theta, how.rows, shape), new_rows(rows, how.rows)
    log_ratio, pull = np.empty(how.rows, theta.dtype), np.empty(how.rows, theta.dtype)
    gradient = np.empty_like(theta)
    norm, clipped, divergence, size, updates = 0.0, 0.0, 0.0, theta.dtype.type(0), 0
    for epoch in range(how.order.shape[0]):
        for first in range(0, x.shape[0] - how.rows + 1, how.rows):
            draw(rows, how, epoch, first, batch)
            network.receive(work, batch.x)
            network.forward(pi, work)
            compare(theta, work, batch, old_spread, log_ratio)
            standardise(batch.advantages)
            weigh(log_ratio, batch.advantages, bound, pull)
            clipped += without_gradient(pull)
            divergence += distance(log_ratio)
            pull_means(theta, work, batch, pull)
            network.backward(pi, work)
            network.gradient(pi, work, Parameters(gradient, shape))
            pull_spread(theta, work, batch, pull, gradient)
            updates += 1
            step = corrected_for(how.betas, how.rate, how.done + updates)
            own, size = clipped_step(actor, gradient, how.bound, step, how.betas)
            norm += own
            if not (norm + size < np.inf):
                return Seen(norm, clipped, divergence, size)
    return Seen(norm / updates, clipped / updates, divergence / updates, size)


@compiled_fast
def means_of(pi: Parameters, x: Array) -> Array:
    """Mu [N, m] at normalised features [N, F]."""
    work = network.new_pass(pi.theta, x.shape[0], pi.shape)
    network.receive(work, x)
    network.forward(pi, work)
    return work.out


@compiled_fast
def new_rows(rows: Rows, count: int) -> Rows:
    """Arrays for a batch."""
    kind = rows.x.dtype
    return Rows(
        np.empty((count, rows.x.shape[1]), kind),
        np.empty((count, rows.noise.shape[1]), kind),
        np.empty((count, rows.means.shape[1]), kind),
        np.empty(count, kind),
    )


@compiled_fast
def draw(rows: Rows, how: Epochs, epoch: int, first: int, batch: Rows) -> None:
    """Copy a batch of an epoch."""
    order = how.order[epoch]
    gather(rows.x, order, first, batch.x)
    gather(rows.noise, order, first, batch.noise)
    gather(rows.means, order, first, batch.means)
    for row in range(batch.advantages.size):
        batch.advantages[row] = rows.advantages[order[first + row]]


@compiled_fast
def standardised(theta: Array, work: Pass, batch: Rows, row: int, i: int) -> Any:
    """z, the distance of an action from the mean in units of sigma."""
    u = batch.means[row, i] + batch.noise[row, i]
    return (u - work.out[row, i]) / spread(theta[theta.size - batch.noise.shape[1] + i])


@compiled_fast
def compare(theta: Array, work: Pass, batch: Rows, old_spread: Array, log_ratio: Array) -> None:
    """Fill the log ratios [B]."""
    m = old_spread.size
    for row in range(log_ratio.size):
        total = log_ratio.dtype.type(0)
        for i in range(m):
            z = standardised(theta, work, batch, row, i)
            e = batch.noise[row, i] / old_spread[i]
            sigma = spread(theta[theta.size - m + i])
            total += HALF * (e * e - z * z) - np.log(sigma / old_spread[i])
        log_ratio[row] = total


@compiled_fast
def standardise(advantages: Array) -> None:
    """Shift and scale a batch to mean 0 and standard deviation 1."""
    total, squares = advantages.dtype.type(0), advantages.dtype.type(0)
    share = ONE / np.float32(advantages.size)
    for row in range(advantages.size):
        total += advantages[row]
    mean = total * share
    for row in range(advantages.size):
        squares += (advantages[row] - mean) * (advantages[row] - mean)
    inverse = ONE / (np.sqrt(squares * share) + SMALL)
    for row in range(advantages.size):
        advantages[row] = (advantages[row] - mean) * inverse


@compiled_fast
def weigh(log_ratio: Array, advantages: Array, bound: Any, pull: Array) -> None:
    """Fill dL/dlog p [B], 0 where the clipped objective is the lesser."""
    share = ONE / np.float32(pull.size)
    for row in range(pull.size):
        ratio = np.exp(log_ratio[row])
        clipped = min(max(ratio, ONE - bound), ONE + bound)
        pays = ratio * advantages[row] <= clipped * advantages[row]
        pull[row] = -share * ratio * advantages[row] if pays else pull.dtype.type(0)


@compiled_fast
def without_gradient(pull: Array) -> float:
    """The share of rows without a gradient."""
    count = 0.0
    for row in range(pull.size):
        count += 1.0 if pull[row] == 0 else 0.0
    return count / pull.size


@compiled_fast
def distance(log_ratio: Array) -> float:
    """Mean of  ratio - 1 - log ratio."""
    total = 0.0
    for row in range(log_ratio.size):
        total += np.exp(log_ratio[row]) - ONE - log_ratio[row]
    return total / log_ratio.size


@compiled_fast
def pull_means(theta: Array, work: Pass, batch: Rows, pull: Array) -> None:
    """Set `out_bar [B, m]`, the adjoints of the means."""
    m = batch.noise.shape[1]
    for row in range(pull.size):
        for i in range(m):
            z = standardised(theta, work, batch, row, i)
            work.out_bar[row, i] = pull[row] * z / spread(theta[theta.size - m + i])


@compiled_fast
def pull_spread(theta: Array, work: Pass, batch: Rows, pull: Array, gradient: Array) -> None:
    """Set the gradient of log sigma, the last m."""
    m = batch.noise.shape[1]
    for i in range(m):
        total = pull.dtype.type(0)
        for row in range(pull.size):
            z = standardised(theta, work, batch, row, i)
            total += pull[row] * (z * z - ONE)
        free = is_free(theta[theta.size - m + i])
        gradient[theta.size - m + i] = total if free else pull.dtype.type(0)
