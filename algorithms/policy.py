"""Policies of a cohort, acting on all its states at once."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.actor import act_rows
from algorithms.network import Shape


class Policy(NamedTuple):
    """What one run's deterministic actor is made of."""

    theta: NDArray[np.float32]
    """[P]"""
    mean: NDArray[np.float32]
    """[F]"""
    inverse: NDArray[np.float32]
    """[F]"""


class Policies:
    """The policies of K runs, stacked; each acts by itself, whatever K is."""

    def __init__(self, policies: Sequence[Policy], shape: Shape) -> None:
        """Copy the policies of a cohort of at least one run."""
        self._theta, self._mean, self._inverse = (
            np.stack(part) for part in zip(*policies, strict=True)
        )
        self._shape = shape

    def set(self, k: int, policy: Policy) -> None:
        """Replace run k's policy."""
        self._theta[k], self._mean[k], self._inverse[k] = policy

    def keep(self, rows: Sequence[int]) -> None:
        """Keep these runs only."""
        kept = list(rows)
        self._theta, self._mean, self._inverse = (
            part[kept] for part in (self._theta, self._mean, self._inverse)
        )

    def act(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """The actions [K, m] for features [K, F]."""
        actions = np.empty((len(features), self._shape.outputs))
        act_rows(self._theta, self._mean, self._inverse, features, self._shape, actions)
        return actions
