"""Failing rows: handles batches in which a row raises.

A simulator refuses a whole batch for one such row, but a run must not depend on its neighbours: the
failing rows are found by bisection, and other rows are computed in their place.
"""

import traceback
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import Divergence, EarlyEnd, Failure, NotFiniteQuantityError
from physics.environment import NotFiniteError

Result = TypeVar("Result")
Run = TypeVar("Run")
Failures = dict[int, Exception]
"""The error of each row that raised, by its index."""


@overload
def call_rows(
    call: Callable[..., Result], *arrays: NDArray[Any], substitutes: NDArray[np.int64]
) -> tuple[Result, Failures]: ...


@overload
def call_rows(
    call: Callable[..., Result], *arrays: NDArray[Any]
) -> tuple[Result | None, Failures]: ...


def call_rows(
    call: Callable[..., Result],
    *arrays: NDArray[Any],
    substitutes: NDArray[np.int64] | None = None,
) -> tuple[Result | None, Failures]:
    """`call(*arrays)`, where every array has a row for each row of the result.

    Args:
        call: computes each row by itself, and raises if it cannot compute one of them.
        arrays: arrays with equal numbers of rows.
        substitutes: the row [rows] that replaces each row that raises; by default one that does
            not raise.

    Returns:
        The result, with the substitutes' rows in place of rows that raise, None if all raise; and
        the failures.

    Raises:
        Exception: if `call` raises for substitutes, or for a batch but for none of its rows alone.
    """
    try:
        return call(*arrays), {}
    except Exception:
        failures = failing_rows(call, *arrays)
        if not failures:
            raise
    rows = np.arange(len(arrays[0]))
    if substitutes is None:
        good = [row for row in rows if row not in failures]
        if not good:
            return None, failures
        substitutes = np.full_like(rows, good[0])
    bad = list(failures)
    rows[bad] = substitutes[bad]
    return call(*(array[rows] for array in arrays)), failures


def failing_rows(call: Callable[..., object], *arrays: NDArray[Any], first: int = 0) -> Failures:
    """The rows of a batch that raise, numbered from `first` on."""
    size = len(arrays[0])
    try:
        call(*arrays)
    except Exception as error:
        if size == 1:
            return {first: error}
        half = size // 2
        return failing_rows(call, *(a[:half] for a in arrays), first=first) | failing_rows(
            call, *(a[half:] for a in arrays), first=first + half
        )
    return {}


def failures_of(failures: Failures, rows: Sequence[int]) -> Failures:
    """The failures of these rows alone, by their index among them."""
    return {k: failures[row] for k, row in enumerate(rows) if row in failures}


def call_each(
    call: Callable[[Run], None], runs: Iterable[Run], end: Callable[[Run, Exception], EarlyEnd]
) -> list[EarlyEnd]:
    """Call for every run; return the early ends of those for which it raises."""
    ends = []
    for run in runs:
        try:
            call(run)
        except Exception as error:
            ends.append(end(run, error))
    return ends


def early_end(seed: int, timestep: int, update: int, error: Exception) -> EarlyEnd:
    """The early end of a run by an error; arguments as in `Divergence`."""
    if isinstance(error, NotFiniteQuantityError | NotFiniteError):
        return Divergence(seed, timestep, update, error.quantity)
    return Failure(seed, timestep, "".join(traceback.format_exception(error)))


def found(result: Result | Exception) -> Result:
    """The result of a row. Raises the row's error."""
    if isinstance(result, Exception):
        raise result
    return result
