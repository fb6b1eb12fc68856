"""Gradient steps on flat parameter vectors: Adam, weight decay, Polyak averaging.

    m <- m + (1 - beta1)(g - m),   v <- v + (1 - beta2)(g^2 - v)
    theta <- theta - rate sqrt(1 - beta2^t) / (1 - beta1^t) m / (sqrt v + EPSILON)

Source: Adam, Kingma and Ba (2014), in the order of computation of their section 2, which is that of
OpenAI Baselines (EPSILON outside the correction).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.finite import is_finite
from algorithms.networks.layer import Array
from algorithms.state import State, fill
from physics.kernels.compiled import compiled_fast

EPSILON = np.float32(1e-8)
ONE = np.float32(1)


class Betas(NamedTuple):
    """The share of each of Adam's moments that an update keeps."""

    first: float
    second: float


USUAL = Betas(0.9, 0.999)


class Learned(NamedTuple):
    """A network in training: flat vectors [P] of one length."""

    theta: Array
    target: Array
    """The slowly following copy; [0] for a network without one."""
    m: Array
    v: Array

    def state(self) -> State:
        """All four vectors by name."""
        return self._asdict()

    def restore(self, state: State) -> None:
        """Overwrite all four."""
        for name, vector in zip(self._fields, self, strict=True):
            fill(vector, state[name])


def learned(theta: NDArray[np.float32]) -> Learned:
    """An untrained network, with a target equal to it."""
    return Learned(theta, theta.copy(), np.zeros_like(theta), np.zeros_like(theta))


def learned_alone(theta: NDArray[np.float32]) -> Learned:
    """An untrained network without a target."""
    return Learned(theta, theta[:0].copy(), np.zeros_like(theta), np.zeros_like(theta))


@compiled_fast
def corrected(rate: float, update: int) -> Any:
    """The step size of Adam's update number `update` (from 1 on)."""
    return corrected_for(USUAL, rate, update)


@compiled_fast
def corrected_for(betas: Betas, rate: float, update: int) -> Any:
    """The step size under other betas than the usual ones."""
    return np.float32(rate * np.sqrt(1.0 - betas.second**update) / (1.0 - betas.first**update))


@compiled_fast
def decay(theta: Array, size: int, rate: Any, gradient: Array) -> None:
    """Add the gradient of `rate / 2 |theta|^2` over the first `size` parameters."""
    for i in range(size):
        gradient[i] += rate * theta[i]


@compiled_fast
def adam(network: Learned, gradient: Array, step: float) -> tuple[Any, Any]:
    """Step the network; return the squared norms of the gradient and of the new theta.

    A norm is not finite if any entry is not.
    """
    return adam_for(USUAL, network, gradient, step)


@compiled_fast
def adam_for(betas: Betas, network: Learned, gradient: Array, step: float) -> tuple[Any, Any]:
    """The same under other betas than the usual ones."""
    theta, m, v = network.theta, network.m, network.v
    of_new, of_square = ONE - np.float32(betas.first), ONE - np.float32(betas.second)
    for i in range(theta.size):
        g = gradient[i]
        m[i] += of_new * (g - m[i])
        v[i] += of_square * (g * g - v[i])
        theta[i] -= step * m[i] / (np.sqrt(v[i]) + EPSILON)
    return squared_norm(gradient), squared_norm(theta)


@compiled_fast
def clipped_step(
    network: Learned, gradient: Array, bound: float, step: float, betas: Betas
) -> tuple[Any, Any]:
    """Step the network down a gradient, shortened to the norm `bound` where it is longer.

    Returns:
        The norm of the gradient before clipping, float64, and the squared norm of the new theta. If
        the former is not finite, nothing is changed.
    """
    norm = long_norm(gradient)
    if not is_finite(norm):
        return norm, gradient.dtype.type(0)
    share = min(1.0, bound / norm) if norm > 0.0 else 1.0
    for i in range(gradient.size):
        gradient[i] *= share
    _, size = adam_for(betas, network, gradient, step)
    return norm, size


@compiled_fast
def long_norm(vector: Array) -> Any:
    """`|vector|`, in float64, so that no square overflows."""
    square = 0.0
    for i in range(vector.size):
        square += np.float64(vector[i]) * np.float64(vector[i])
    return np.sqrt(square)


@compiled_fast
def squared_norm(vector: Array) -> Any:
    """`|vector|^2`; the sum has its own loop (algorithms.matching.losses)."""
    total = vector.dtype.type(0)
    for i in range(vector.size):
        total += vector[i] * vector[i]
    return total


@compiled_fast
def follow(network: Learned, tau: Any) -> None:
    """Move the target a share `tau` of the way to the network."""
    for i in range(network.theta.size):
        network.target[i] += tau * (network.theta[i] - network.target[i])
