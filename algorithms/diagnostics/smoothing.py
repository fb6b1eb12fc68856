"""Smoothing: bias and variance of the exact gradient of a return smoothed by noise.

    F(v) = E_w[R_H(w)],    a_0 = pi(s_0) + v + w_0,    a_t = pi(s_t) + w_t,    w ~ N(0, noise^2)

Two estimates of dF/dv at v = 0, each from one antithetic pair w+ and w-, which differ in the sign
of w_0 alone and share the noise of all later actions (common random numbers):

    exact        g1 = 1/2 (dR/dw_0 at w+  +  dR/dw_0 at w-)
    zeroth-order g0 = (R(w+) - R(w-)) w_0 / (2 noise^2)

The mean of g0 is dF/dv for any R (Stein's identity). The mean of g1 is dF/dv only if R is
continuous: at a jump, such as a termination or a contact that is made or missed, it lacks the
jump's contribution. Where R is continuous but stiff, g1 is right and its variance may exceed that
of g0.

From N pairs in a state, with d = g1 - g0 of the same pair,

    bias^2       |mean d|^2 - tr var(d) / N,     of mean 0 where g1 has no bias
    resolution^2 tr var(d) / N,                  what |mean d|^2 is on average without a bias
    std^2        tr var(g), of one pair
    norm^2       |mean g0|^2 - tr var(g0) / N,   of dF/dv

each averaged over the states. These pairs cannot distinguish a bias below the resolution from 0. A
negative estimate of a square is reported as 0.

Sources: Suh et al. (2022), "Do differentiable simulators give better policy gradients?"; Pang et
al. (2023), "Global planning for contact-rich manipulation via local smoothing of quasi-dynamic
contact models".
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from algorithms.diagnostics.closed_loop import Controller, roll_out, value_gradient
from physics.environment import Environment, FloatArray
from physics.randomness import generator


class Smoothing(NamedTuple):
    """The estimates of one horizon and noise."""

    horizon: int
    noise: float
    norm: float
    """Norm of the gradient of the smoothed return."""
    bias: float
    """Bias of the exact estimate."""
    resolution: float
    exact_std: float
    zeroth_std: float


def smoothing(
    environment: Environment,
    controller: Controller,
    states: FloatArray,
    horizons: Sequence[int],
    noise: float,
    *,
    pairs: int,
    seed: int,
) -> list[Smoothing]:
    """Compare both estimates at states [S, n], by horizon.

    Args:
        environment: the task.
        controller: the policy.
        states: where the rollouts start.
        horizons: the values of H.
        noise: standard deviation of each action's.
        pairs: N, of each state.
        seed: of the noise.
    """
    shape = (len(states), max(horizons), pairs, environment.action_size)
    noises = noise * generator(seed, "diagnostics: smoothing").standard_normal(shape)
    by_state = [
        estimates(environment, controller, state, horizons, each, noise)
        for state, each in zip(states, noises, strict=True)
    ]
    exact, zeroth = (np.stack(each) for each in zip(*by_state, strict=True))
    return [
        compared(horizon, noise, exact[:, i], zeroth[:, i]) for i, horizon in enumerate(horizons)
    ]


def estimates(
    environment: Environment,
    controller: Controller,
    state: FloatArray,
    horizons: Sequence[int],
    noise: FloatArray,
    scale: float,
) -> tuple[FloatArray, FloatArray]:
    """Exact and zeroth-order estimates [horizons, N, m] at one state [n].

    Args:
        environment: the task.
        controller: the policy.
        state: where the rollouts start.
        horizons: the values of H.
        noise: w+ of each pair [T, N, m].
        scale: its standard deviation.
    """
    starts = np.repeat(state[None], noise.shape[1], axis=0)
    opposite = np.concatenate([-noise[:1], noise[1:]])
    plus, minus = (
        roll_out(environment, controller, starts, len(noise), each) for each in (noise, opposite)
    )
    exact, zeroth = [], []
    for horizon in horizons:
        slopes = value_gradient(plus, horizon).by_action + value_gradient(minus, horizon).by_action
        change = plus.rewards[:horizon].sum(axis=0) - minus.rewards[:horizon].sum(axis=0)
        exact.append(slopes / 2)
        zeroth.append(change[:, None] * noise[0] / (2 * scale**2))
    return np.stack(exact), np.stack(zeroth)


def compared(horizon: int, noise: float, exact: FloatArray, zeroth: FloatArray) -> Smoothing:
    """The numbers of both estimates [S, N, m]."""
    pairs, difference = exact.shape[1], exact - zeroth
    spread = variance(difference) / pairs
    return Smoothing(
        horizon=horizon,
        noise=noise,
        norm=root(square_of_mean(zeroth) - variance(zeroth) / pairs),
        bias=root(square_of_mean(difference) - spread),
        resolution=root(spread),
        exact_std=root(variance(exact)),
        zeroth_std=root(variance(zeroth)),
    )


def square_of_mean(estimates: FloatArray) -> float:
    """`|mean over N|^2` of estimates [S, N, m], averaged over S."""
    return float(np.square(estimates.mean(axis=1)).sum(axis=1).mean())


def variance(estimates: FloatArray) -> float:
    """The trace of the variance over N, averaged over S."""
    return float(estimates.var(axis=1, ddof=1).sum(axis=1).mean())


def root(square: float) -> float:
    """The square root; 0 for a negative number."""
    return float(np.sqrt(max(square, 0.0)))
