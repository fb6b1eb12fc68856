"""End: which states end a robot's episode, and `Health`, which ends it outside an open box."""

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

import numpy as np

from physics.environment import BoolArray, FloatArray, IntArray
from physics.kernels.compiled import compiled


@runtime_checkable
class End(Protocol):
    """Where an episode ends."""

    def mark(self, next_states: FloatArray, terminated: BoolArray) -> None:
        """Fill `terminated` [batch]: which next states [batch, 2n] end it."""


@compiled
def _mark_rows(
    coordinates: IntArray,
    lowest: FloatArray,
    highest: FloatArray,
    next_states: FloatArray,
    terminated: BoolArray,
) -> None:
    """Fill `terminated` [batch]."""
    for row in range(next_states.shape[0]):
        terminated[row] = False
        for i in range(coordinates.shape[0]):
            value = next_states[row, coordinates[i]]
            terminated[row] |= not lowest[i] < value < highest[i]


class Health:
    """The box of a healthy robot's states."""

    def __init__(self, ranges: Mapping[int, tuple[float, float]]) -> None:
        """Lay out the box.

        Args:
            ranges: coordinate of the state -> its bounds, both outside the box. A coordinate that
                is not named is free.

        Raises:
            ValueError: for bounds with nothing between them.
        """
        for coordinate, (low, high) in ranges.items():
            if not low < high:
                raise ValueError(
                    f"coordinate {coordinate} must lie in (low, high), low < high, "
                    f"not in ({low}, {high})"
                )
        self._coordinates = np.array(list(ranges), np.int64)
        self._lowest = np.array([low for low, _ in ranges.values()], np.float64)
        self._highest = np.array([high for _, high in ranges.values()], np.float64)

    def mark(self, next_states: FloatArray, terminated: BoolArray) -> None:
        """Fill `terminated` [batch]: which next states [batch, 2n] are outside the box."""
        _mark_rows(self._coordinates, self._lowest, self._highest, next_states, terminated)


FOREVER = Health({})
"""No state ends the episode."""
