"""Learning curves: mean and band over seeds, exact, on the steps where the seeds were measured.

    mean_j = 1/n_j sum_i y_ij        s_j^2 = 1/(n_j - 1) sum_i (y_ij - mean_j)^2

    i    a seed            j    a point of the grid
    y    its value there   n_j  seeds with a finite value there

The grid is the union of the seeds' own steps, thinned by leaving points out, never by averaging
neighbours. A seed that was not measured at a point of the grid, between two points where it was,
is interpolated linearly; outside its own range it does not count. Seeds of one cell are measured
at the same timesteps, so along timesteps and updates nothing is interpolated.

Bands: std, mean -+ s; ci95, mean -+ t s / sqrt(n) with t the 97.5 % quantile of Student's
distribution with n - 1 degrees of freedom; iqr, the 25 % and 75 % quantiles (linear). std and ci95
are not defined for n = 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

Floats = NDArray[np.float64]
Band = Literal["std", "ci95", "iqr"]


@dataclass(frozen=True)
class Series:
    """What one seed measured: values `y` [k] at `x` [k], in the order they were measured."""

    x: Floats
    y: Floats


@dataclass(frozen=True)
class Curve:
    """Seeds together, on one grid of p points; NaN where a value is not defined.

    x                [p] increasing
    mean, low, high  [p]
    n                [p] seeds with a finite value
    values           [seeds, p] each seed alone
    is_interpolated  whether any of `values` was not measured but lies between two that were
    """

    x: Floats
    mean: Floats
    low: Floats
    high: Floats
    n: NDArray[np.int64]
    values: Floats
    is_interpolated: bool


def aggregate(series: Sequence[Series], band: Band, max_points: int) -> Curve:
    """Return the curve of seeds; `max_points` is at least 2. No seed measured: no points."""
    ordered = _increasing(series)
    grids = {id(one.x): one.x for one in ordered}  # runs may share them
    x = thin(_union(list(grids.values())), max_points)
    places = {key: _Places.of(grid, x) for key, grid in grids.items()}
    values = np.full((len(ordered), len(x)), np.nan)
    for row, one in zip(values, ordered, strict=True):
        places[id(one.x)].fill(row, one, x)
    is_interpolated = any(each.is_between.any() for each in places.values())
    values[~np.isfinite(values)] = np.nan
    n = np.isfinite(values).sum(axis=0)
    with np.errstate(all="ignore"):
        mean = np.nansum(values, axis=0) / n
        low, high = _bounds(values, mean, n, band)
    return Curve(x, mean, low, high, n, values, is_interpolated)


def thin(x: Floats, max_points: int) -> Floats:
    """Return every k-th point and the last, at most `max_points`.

    Counted from the first, so that a growing curve keeps its points until k itself grows.
    """
    if len(x) <= max_points:
        return x
    stride = math.ceil((len(x) - 1) / (max_points - 1))
    kept = np.arange(0, len(x), stride)
    if kept[-1] != len(x) - 1:
        kept = np.append(kept, len(x) - 1)
    return x[kept]


def _increasing(series: Sequence[Series]) -> list[Series]:
    """Keep the last value at each x: along Jacobians, `ddpg` stands at 0 for ever."""
    grids = {id(one.x): one.x for one in series}
    increasing = {key for key, grid in grids.items() if np.all(np.diff(grid) > 0)}
    return [one if id(one.x) in increasing else _last_at_each(one) for one in series]


def _last_at_each(series: Series) -> Series:
    reversed_x, first = np.unique(series.x[::-1], return_index=True)
    return Series(reversed_x, series.y[::-1][first])


def _union(grids: Sequence[Floats]) -> Floats:
    if not grids:
        return np.empty(0)
    longest = max(grids, key=len)
    if all(np.array_equal(grid, longest[: len(grid)]) for grid in grids):
        return longest
    return np.unique(np.concatenate(grids))


@dataclass(frozen=True)
class _Places:
    """Where the points [p] of a grid stand among those of a series [n].

    is_measured  which are among them, [p]
    at           the place of each that is, [<= p]
    is_between   which are not, but lie between two, [p]
    """

    is_measured: NDArray[np.bool_]
    at: NDArray[np.intp]
    is_between: NDArray[np.bool_]

    @classmethod
    def of(cls, own: Floats, x: Floats) -> "_Places":
        if len(own) == 0:
            nowhere = np.zeros(len(x), np.bool_)
            return cls(nowhere, np.empty(0, np.intp), nowhere)
        at = np.minimum(np.searchsorted(own, x), len(own) - 1)
        is_measured = own[at] == x
        is_between = ~is_measured & (x > own[0]) & (x < own[-1])
        return cls(is_measured, at[is_measured], is_between)

    def fill(self, row: Floats, series: Series, x: Floats) -> None:
        """Write the values of a series at x into a row [p]."""
        row[self.is_measured] = series.y[self.at]
        if self.is_between.any():
            with np.errstate(all="ignore"):
                row[self.is_between] = np.interp(x[self.is_between], series.x, series.y)


def _bounds(
    values: Floats, mean: Floats, n: NDArray[np.int64], band: Band
) -> tuple[Floats, Floats]:
    if band == "iqr":
        ascending = np.sort(values, axis=0)  # NaN last
        return _quantile(ascending, n, 0.25), _quantile(ascending, n, 0.75)
    deviation = np.sqrt(np.nansum((values - mean) ** 2, axis=0) / (n - 1))
    deviation[n < 2] = np.nan
    if band == "ci95":
        deviation *= stdtrit(n - 1, 0.975) / np.sqrt(n)
    return mean - deviation, mean + deviation


def _quantile(ascending: Floats, n: NDArray[np.int64], q: float) -> Floats:
    """Return the linear quantile of the first n_j of each column."""
    if len(ascending) == 0:
        return np.full(len(n), np.nan)
    rank = np.maximum(n - 1, 0) * q
    below = np.floor(rank).astype(np.int64)
    above = np.minimum(below + 1, np.maximum(n - 1, 0))
    columns = np.arange(ascending.shape[1])
    start = ascending[below, columns]
    return start + (rank - below) * (ascending[above, columns] - start)
