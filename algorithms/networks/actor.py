"""The actor: a network with a tanh at its end, and gradients pulled back through it.

    a = tanh(out(x)),    outbar = abar (1 - a^2)

A stochastic actor has the same number of outputs again, for the spread of its noise
(algorithms.networks.gaussian); without noise, it uses only the first half.
"""

import numpy as np
from numpy.typing import NDArray

from algorithms.networks import network
from algorithms.networks.gaussian import spread
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import normalise
from algorithms.networks.shape import Shape
from algorithms.networks.squash import squash, squash_slope
from physics.kernels.compiled import compiled_fast

ONE = np.float32(1)


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

    The noise is that of a stochastic actor, which has a spread for each action, or it is added to
    the actions of a deterministic one, which stay within their bounds.

    Shapes: theta [K, P], mean, inverse and features [K, F], actions [K, m], noise [K, m], or [K, 0]
    for none.
    """
    m = actions.shape[1]
    is_noisy, is_stochastic = noise.shape[1] > 0, shape.outputs > m
    work = network.new_pass(theta, 1, shape)
    for k in range(theta.shape[0]):
        for i in range(mean.shape[1]):
            work.x[0, i] = normalise(np.float32(features[k, i]), mean[k, i], inverse[k, i])
        network.forward(Parameters(theta[k], shape), work)
        for i in range(m):
            u = work.out[0, i]
            if is_noisy and is_stochastic:
                u += spread(work.out[0, m + i]) * noise[k, i]
            a = squash(u)
            if is_noisy and not is_stochastic:
                a = min(max(a + noise[k, i], -ONE), ONE)
            actions[k, i] = a
