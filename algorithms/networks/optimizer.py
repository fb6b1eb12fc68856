"""Gradient steps on flat parameter vectors: Adam, weight decay, Polyak averaging.

    m <- m + (1 - beta1)(g - m),   v <- v + (1 - beta2)(g^2 - v)
    theta <- theta - rate sqrt(1 - beta2^t) / (1 - beta1^t) m / (sqrt v + EPSILON)

Source: Adam, Kingma and Ba (2014), in the order of computation of their section 2, which is that of
OpenAI Baselines (EPSILON outside the correction).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.layer import Array
from algorithms.state import State, fill
from physics.kernels.compiled import compiled_fast

BETA1, BETA2 = np.float32(0.9), np.float32(0.999)
EPSILON = np.float32(1e-8)
ONE = np.float32(1)


class Learned(NamedTuple):
    """A network in training: flat vectors [P] of one length."""

    theta: Array
    target: Array
    """The slowly following copy; [0] where none is wanted."""
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
    """A network about to be trained, its target equal to it."""
    return Learned(theta, theta.copy(), np.zeros_like(theta), np.zeros_like(theta))


def learned_alone(theta: NDArray[np.float32]) -> Learned:
    """A network about to be trained, without a target."""
    return Learned(theta, theta[:0].copy(), np.zeros_like(theta), np.zeros_like(theta))


@compiled_fast
def corrected(rate: float, update: int) -> Any:
    """The step size that Adam's update number `update` (from 1 on) takes."""
    return np.float32(rate * np.sqrt(1.0 - 0.999**update) / (1.0 - 0.9**update))


@compiled_fast
def decay(theta: Array, size: int, rate: Any, gradient: Array) -> None:
    """Add the gradient of `rate / 2 |theta|^2` over the first `size` parameters."""
    for i in range(size):
        gradient[i] += rate * theta[i]


@compiled_fast
def adam(network: Learned, gradient: Array, step: float) -> tuple[Any, Any]:
    """Step the network; return the squared norms of the gradient and of the new theta.

    Either is not finite if any entry is not.
    """
    theta, m, v = network.theta, network.m, network.v
    for i in range(theta.size):
        g = gradient[i]
        m[i] += (ONE - BETA1) * (g - m[i])
        v[i] += (ONE - BETA2) * (g * g - v[i])
        theta[i] -= step * m[i] / (np.sqrt(v[i]) + EPSILON)
    return squared_norm(gradient), squared_norm(theta)


@compiled_fast
def squared_norm(vector: Array) -> Any:
    """`|vector|^2`; a sum in a loop of its own (algorithms.matching.losses)."""
    total = vector.dtype.type(0)
    for i in range(vector.size):
        total += vector[i] * vector[i]
    return total


@compiled_fast
def follow(network: Learned, tau: Any) -> None:
    """Move the target a share `tau` of the way to the network."""
    for i in range(network.theta.size):
        network.target[i] += tau * (network.theta[i] - network.target[i])
