"""The actor: a network with a tanh at its end, and gradients pulled back through it.

    a = tanh(out(x)),    outbar = abar (1 - a^2)

A stochastic actor has as many outputs again, for the spread of its noise
(algorithms.networks.gaussian); without noise it takes the first half alone.
"""

import numpy as np
from numpy.typing import NDArray

from algorithms.networks import network
from algorithms.networks.gaussian import spread
from algorithms.networks.layer import Array
from algorithms.networks.network import Parameters, Pass, Shape
from algorithms.networks.scaling import normalise
from algorithms.networks.squash import squash, squash_slope
from physics.kernels.compiled import compiled_fast


@compiled_fast
def choose(actor: Parameters, work: Pass, actions: Array) -> None:
    """The actions [B, m] for the normalised features in `work.x`."""
    network.forward(actor, work)
    for row in range(actions.shape[0]):
        for i in range(actions.shape[1]):
            actions[row, i] = squash(work.out[row, i])


@compiled_fast
def pull_back(actions: Array, action_bar: Array, first: int, work: Pass) -> None:
    """Set `out_bar` from the adjoints of the actions: columns `first` onwards of `action_bar`."""
    for row in range(actions.shape[0]):
        for i in range(actions.shape[1]):
            work.out_bar[row, i] = action_bar[row, first + i] * squash_slope(actions[row, i])


@compiled_fast
def act_rows(
    theta: NDArray[np.float32],
    mean: NDArray[np.float32],
    inverse: NDArray[np.float32],
    noise: NDArray[np.float32],
    features: NDArray[np.float64],
    shape: Shape,
    actions: NDArray[np.float64],
) -> None:
    """Let actor `theta[k]` act on `features[k]`, each row by itself.

    Shapes: theta [K, P], mean, inverse and features [K, F], actions [K, m], noise [K, m] for a
    stochastic actor, [K, 0] for none.
    """
    m = actions.shape[1]
    work = network.new_pass(theta, 1, shape)
    for k in range(theta.shape[0]):
        for i in range(mean.shape[1]):
            work.x[0, i] = normalise(np.float32(features[k, i]), mean[k, i], inverse[k, i])
        network.forward(Parameters(theta[k], shape), work)
        for i in range(m):
            u = work.out[0, i]
            if noise.shape[1] > 0:
                u += spread(work.out[0, m + i]) * noise[k, i]
            actions[k, i] = squash(u)
