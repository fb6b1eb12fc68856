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
    ordered = [_increasing(one) for one in series]
    x = thin(_union([one.x for one in ordered]), max_points)
    values = np.full((len(ordered), len(x)), np.nan)
    is_interpolated = False
    for row, one in zip(values, ordered, strict=True):
        is_interpolated |= _place(one, x, row)
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


def _increasing(series: Series) -> Series:
    """Keep the last value at each x: along Jacobians, `ddpg` stands at 0 for ever."""
    if len(series.x) < 2 or np.all(np.diff(series.x) > 0):
        return series
    reversed_x, first = np.unique(series.x[::-1], return_index=True)
    return Series(reversed_x, series.y[::-1][first])


def _union(grids: Sequence[Floats]) -> Floats:
    if not grids:
        return np.empty(0)
    longest = max(grids, key=len)
    if all(np.array_equal(grid, longest[: len(grid)]) for grid in grids):
        return longest
    return np.unique(np.concatenate(grids))


def _place(series: Series, x: Floats, row: Floats) -> bool:
    """Fill `row` [p] with the series' values at `x` [p]; whether any had to be interpolated."""
    if len(series.x) == 0:
        return False
    if len(series.x) <= len(x) and np.array_equal(series.x, x[: len(series.x)]):
        row[: len(series.x)] = series.y
        return False
    at = np.minimum(np.searchsorted(series.x, x), len(series.x) - 1)
    is_measured = series.x[at] == x
    row[is_measured] = series.y[at[is_measured]]
    is_between = ~is_measured & (x > series.x[0]) & (x < series.x[-1])
    with np.errstate(all="ignore"):
        row[is_between] = np.interp(x[is_between], series.x, series.y)
    return bool(is_between.any())


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
