"""Policies of a cohort, acting on all its states at once."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.actor import act_rows
from algorithms.networks.shape import Shape

NEARLY_ONE = float(np.nextafter(np.float32(1), np.float32(0)))
"""The largest action whose inverse tanh is finite."""


class Policy(NamedTuple):
    """The actor of one run: a network, the features' scale, and the noise of its actions."""

    theta: NDArray[np.float32]
    """[P]"""
    mean: NDArray[np.float32]
    """[F]"""
    inverse: NDArray[np.float32]
    """[F]"""
    noise: NDArray[np.float32]
    """[T, m], a row for each of the next T steps; T = 0 for no noise (networks.actor)."""


def deterministic(
    theta: NDArray[np.float32],
    mean: NDArray[np.float32],
    inverse: NDArray[np.float32],
    action_size: int,
) -> Policy:
    """A policy that acts without noise."""
    return Policy(theta, mean, inverse, np.empty((0, action_size), np.float32))


def uniform(
    policy: Policy, shape: Shape, size: tuple[int, int], draws: np.random.Generator
) -> Policy:
    """A policy whose next `size` (T, m) actions are uniform: noise about a network of zeros.

    A deterministic actor's noise is added to its action 0. A stochastic one has spread 1 there, so
    that its action is the tanh of its noise.
    """
    actions = draws.uniform(-NEARLY_ONE, NEARLY_ONE, size)
    noise = np.arctanh(actions) if shape.outputs > size[1] else actions
    return policy._replace(theta=np.zeros_like(policy.theta), noise=noise.astype(np.float32))


class Policies:
    """The policies of K runs, stacked; each acts by itself, whatever K is."""

    def __init__(self, policies: Sequence[Policy], shape: Shape) -> None:
        """Copy the policies of a cohort of at least one run."""
        self._theta, self._mean, self._inverse, self._noise = (
            np.stack(part) for part in zip(*policies, strict=True)
        )
        self._steps = np.zeros(len(policies), np.int64)
        self._shape = shape

    def set(self, k: int, policy: Policy) -> None:
        """Replace run k's policy."""
        self._theta[k], self._mean[k], self._inverse[k], self._noise[k] = policy
        self._steps[k] = 0

    def keep(self, rows: Sequence[int]) -> None:
        """Keep these runs only."""
        kept = list(rows)
        self._theta, self._mean, self._inverse, self._noise, self._steps = (
            part[kept]
            for part in (self._theta, self._mean, self._inverse, self._noise, self._steps)
        )

    def act(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """The actions [K, m] for features [K, F].

        Raises:
            IndexError: if a policy that acts with noise has used it up.
        """
        runs, steps, m = self._noise.shape
        actions, noise = np.empty((runs, m)), np.empty((runs, 0), np.float32)
        if steps:
            noise = self._noise[np.arange(runs), self._steps]
            self._steps += 1
        act_rows(self._theta, self._mean, self._inverse, noise, features, self._shape, actions)
        return actions
