"""The actor of on-policy learners: a tanh-Gaussian with a separate spread for each action.

    a = tanh(mu(s) + sigma e),   e ~ N(0, 1)

Its parameters are those of the network of mu, followed by log sigma [m], which does not depend on
the state: theta = [network | log sigma]. Code for the network alone reads its part of theta and
acts with the mean, tanh(mu(s)).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.networks import network
from algorithms.networks.gaussian import HIGHEST, LOWEST
from algorithms.networks.layer import Array
from algorithms.networks.parameters import Parameters, initial_theta
from algorithms.networks.policy import Policy
from algorithms.networks.scaling import normalise
from algorithms.networks.shape import Shape
from algorithms.networks.squash import squash
from physics.kernels.compiled import compiled_fast

Floats = NDArray[np.float64]


def initial(shape: Shape, generator: np.random.Generator, spread: float) -> NDArray[np.float32]:
    """Draw theta, every sigma equal to `spread`."""
    log_sigma = np.full(shape.outputs, np.log(spread), np.float32)
    return np.concatenate([initial_theta(shape, generator), log_sigma])


def spread_of(theta: NDArray[np.float32], m: int) -> NDArray[np.float32]:
    """Sigma [m]."""
    sigma: NDArray[np.float32] = np.exp(np.clip(theta[-m:], LOWEST, HIGHEST))
    return sigma


@compiled_fast
def is_free(log_sigma: Any) -> Any:
    """Whether a spread lies within its bounds, so that it has a gradient."""
    return LOWEST <= log_sigma <= HIGHEST


class Explorers:
    """The actors of K runs, each for the same number of environments."""

    def __init__(
        self, policies: Sequence[Policy], noise: NDArray[np.float32], shape: Shape
    ) -> None:
        """Stack the policies; they add `noise [T, K E, m]` to their means."""
        self._theta, self._mean, self._inverse = (
            np.stack(part) for part in list(zip(*policies, strict=True))[:3]
        )
        self._noise = noise
        self._shape = shape

    def act(self, features: Floats, t: int) -> Floats:
        """The actions [K E, m] for features [K E, F] at step t."""
        actions = np.empty(self._noise.shape[1:])
        explore(
            self._theta, self._mean, self._inverse, self._noise[t], features, self._shape, actions
        )
        return actions


@compiled_fast
def explore(
    theta: Array,
    mean: Array,
    inverse: Array,
    noise: Array,
    features: Floats,
    shape: Shape,
    actions: Floats,
) -> None:
    """Let actor k act on its rows, one after the other, with noise [K E, m] added to its means.

    Shapes: theta [K, P], mean and inverse [K, F], features [K E, F], actions [K E, m].
    """
    rows = features.shape[0] // theta.shape[0]
    work = network.new_pass(theta, rows, shape)
    for k in range(theta.shape[0]):
        first = k * rows
        for row in range(rows):
            for i in range(mean.shape[1]):
                feature = np.float32(features[first + row, i])
                work.x[row, i] = normalise(feature, mean[k, i], inverse[k, i])
        network.forward(Parameters(theta[k], shape), work)
        for row in range(rows):
            for i in range(actions.shape[1]):
                actions[first + row, i] = squash(work.out[row, i] + noise[first + row, i])
