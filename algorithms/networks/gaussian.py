"""The tanh-Gaussian policy: samples, their log probability, and gradients pulled back.

    a = tanh u,   u = mu + sigma noise,   (mu, log sigma) = the network's 2 m outputs
    log pi(a) = sum over actions of  -noise^2 / 2 - log sigma - log(2 pi) / 2 - log(1 - tanh^2 u)

The last term is computed in a form that neither overflows nor cancels, however large u is:

    log(1 - tanh^2 u) = 2 (log 2 - |u| - log(1 + exp(-2 |u|))),   derivative -2 tanh u

`log sigma` is clipped to [-20, 2], and has no gradient beyond. For S(a, log pi), with the adjoints
abar of a and lbar of log pi, and with constant noise (reparameterised):

    ubar = abar (1 - a^2) + 2 lbar a,   mubar = ubar,   (log sigma)bar = ubar sigma noise - lbar

Source: soft actor-critic, Haarnoja et al. (2018), appendix C, whose code has
`log(1 - tanh^2 u + 1e-6)` instead.
"""

from typing import Any

import numpy as np

from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.parameters import Parameters
from algorithms.networks.squash import squash, squash_slope
from physics.kernels.compiled import compiled_fast

LOWEST, HIGHEST = np.float32(-20), np.float32(2)
HALF, ONE, TWO = np.float32(0.5), np.float32(1), np.float32(2)
LOG_2, HALF_LOG_TAU = np.float32(np.log(2)), np.float32(np.log(2 * np.pi) / 2)


@compiled_fast
def spread(log_sigma: Any) -> Any:
    """Sigma, from the network's output."""
    return np.exp(min(max(log_sigma, LOWEST), HIGHEST))


@compiled_fast
def sample(policy: Parameters, work: Pass, noise: Array, actions: Array, log_pi: Array) -> None:
    """Fill actions [B, m] and their log pi [B], for features in `work.x` and `noise [B, m]`."""
    network.forward(policy, work)
    rows, m = actions.shape
    real = actions.dtype.type
    for row in range(rows):
        total = real(0)
        for i in range(m):
            log_sigma = min(max(work.out[row, m + i], LOWEST), HIGHEST)
            e = noise[row, i]
            u = work.out[row, i] + np.exp(log_sigma) * e
            size = abs(u)
            shrinkage = TWO * (LOG_2 - size - np.log(ONE + np.exp(-TWO * size)))
            total -= HALF * e * e + log_sigma + HALF_LOG_TAU + shrinkage
            actions[row, i] = squash(u)
        log_pi[row] = total


@compiled_fast
def pull_back(
    noise: Array, actions: Array, action_bar: Array, first: int, log_pi_bar: Any, work: Pass
) -> None:
    """Set `out_bar`, after `sample`: abar is columns `first` onwards of `action_bar`."""
    rows, m = actions.shape
    real = actions.dtype.type
    for row in range(rows):
        for i in range(m):
            a, log_sigma = actions[row, i], work.out[row, m + i]
            u_bar = action_bar[row, first + i] * squash_slope(a) + TWO * log_pi_bar * a
            work.out_bar[row, i] = u_bar
            free = LOWEST <= log_sigma <= HIGHEST
            by_spread = u_bar * np.exp(log_sigma) * noise[row, i] - log_pi_bar if free else real(0)
            work.out_bar[row, m + i] = by_spread
