"""Domain: which states a step may begin with, and the errors for rows that it may not.

A state lies in the domain if all its numbers are finite and between the task's bounds, except for
rounding: the state may have been stored as float32. A task whose domain has another shape adds to
this.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from physics.row_checks import FloatArray, are_inside

ROUNDING = 1e-6
"""How far beyond a bound a state may lie, relative to the bound where that is larger than 1."""


class RowsError(ValueError):
    """An error in some rows of a batch.

    Attributes:
        rows: which ones.
    """

    def __init__(self, message: str, rows: Sequence[int] | NDArray[np.int64]) -> None:
        """Blame rows of a batch."""
        self.rows = tuple(int(row) for row in rows)
        super().__init__(message, self.rows)

    def __str__(self) -> str:
        """The message alone."""
        return str(self.args[0])


class NotFiniteError(RowsError):
    """A NaN or an infinity in the input or the result of a step.

    Attributes:
        rows: which ones.
        quantity: what is not finite in the first of them, such as "next state".
    """

    def __init__(
        self, message: str, rows: Sequence[int] | NDArray[np.int64], quantity: str
    ) -> None:
        """Blame rows of a batch."""
        super().__init__(message, rows)
        self.quantity = quantity
        self.args = (*self.args, quantity)


class DomainError(RowsError):
    """States outside the task's domain, such as beyond a wall."""


class Domain:
    """The bounds of a task's states."""

    def __init__(self, task: str, size: int, bounds: Mapping[int, tuple[float, float]]) -> None:
        """Lay out the bounds.

        Args:
            task: its name, for errors.
            size: n.
            bounds: coordinate -> least and greatest value.
        """
        self._task = task
        self._bounds = dict(bounds)
        # Without a bound, the limit is the greatest number: NaN and infinity lie outside it.
        self._highest = np.full(size, np.finfo(np.float64).max)
        self._lowest = -self._highest
        for i, (least, greatest) in bounds.items():
            self._lowest[i] = max(self._lowest[i], least - ROUNDING * max(1.0, abs(least)))
            self._highest[i] = min(self._highest[i], greatest + ROUNDING * max(1.0, abs(greatest)))

    def outside(self, states: FloatArray) -> NDArray[np.bool_]:
        """Which states [batch, n] lie beyond a bound, or are not finite."""
        within = (states >= self._lowest) & (states <= self._highest)
        inside: NDArray[np.bool_] = np.logical_and.reduce(within, axis=1)
        return ~inside

    def check(self, states: FloatArray, actions: FloatArray) -> None:
        """Check that all states [batch, n] lie within the bounds and that all actions are finite.

        Raises:
            NotFiniteError: for NaN and infinity.
            DomainError: for states beyond a bound.
        """
        if are_inside(states, actions, self._lowest, self._highest):
            return
        finite = np.isfinite(states).all(axis=1) & np.isfinite(actions).all(axis=1)
        if not finite.all():
            row = int(np.argmin(finite))
            raise NotFiniteError(
                f"{self._task}: states and actions must be finite, but row {row} has "
                f"state {states[row].tolist()}, action {actions[row].tolist()}",
                np.flatnonzero(~finite),
                "action" if np.isfinite(states[row]).all() else "state",
            )
        within = (f"{low:.6g} <= s[{i}] <= {high:.6g}" for i, (low, high) in self._bounds.items())
        raise self.error(states, self.outside(states), " and ".join(within))

    def error(
        self, states: FloatArray, outside: NDArray[np.bool_], description: str
    ) -> DomainError:
        """The error for states, some of which lie outside a domain; `description` describes it."""
        row = int(np.argmax(outside))
        return DomainError(
            f"{self._task}: row {row} lies outside the domain, {description}: "
            f"its state is {states[row].tolist()}",
            np.flatnonzero(outside),
        )
