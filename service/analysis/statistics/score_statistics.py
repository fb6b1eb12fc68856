"""Statistics of scores over tasks (Agarwal et al., NeurIPS 2021), with bootstrap intervals.

    IQM         mean of the middle half of all runs of all tasks: of N scores the floor(N / 4)
                lowest and as many of the highest are left out
    profile(t)  mean over tasks of the share of runs whose score exceeds t
    P(X > Y)    mean over tasks of the share of pairs (x, y) with x > y, a tie counting half:
                over all pairs of runs (the Mann-Whitney statistic), or over those of equal seed

The interval of P(X > Y) is the bootstrap's, unless no resample differs from the others, as where
every pair is won: then the bootstrap says nothing, however few the pairs are, and the interval is
Wilson's (1927) for a share p of N pairs, z the 97.5 % quantile of the normal distribution:

    (p + z^2 / 2N -+ z sqrt(p (1 - p) / N + z^2 / 4N^2)) / (1 + z^2 / N)

    N   T^2 / sum_t 1/n_t, with n_t the pairs of task t of T, or its runs of the one that has fewer

Scores of one algorithm are a list of tasks, in it the finite scores of its runs [n], n >= 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from service.analysis.curves import Floats
from service.analysis.statistics.stratified_bootstrap import (
    RESAMPLES,
    TAILS,
    Estimate,
    draw_counts,
    estimate,
)

TRIMMED = 0.25  # at either end
SAME = 1e-12  # shares that differ by rounding alone

Scores = Sequence[Floats]
Seeds = Sequence[tuple[int, ...]]


@dataclass(frozen=True)
class Profile:
    """The shares of runs above thresholds, with their 95 % band, each [k]; NaN: not defined."""

    share: Floats
    low: Floats
    high: Floats


def interquartile_mean(scores: Scores) -> Estimate:
    """Return the IQM."""
    values = np.concatenate(scores)
    order = np.argsort(values, kind="stable")
    counts = np.concatenate(_counts(scores), axis=1)[:, order]
    (value,) = _middle_means(np.ones((1, len(values))), values[order])
    resampled = _middle_means(counts, values[order])
    return estimate(float(value), resampled, is_defined=_has_spread(scores))


def performance_profile(scores: Scores, thresholds: Floats) -> Profile:
    """Return the profile at thresholds [k]."""
    above = [(values[:, None] > thresholds).astype(np.float64) for values in scores]
    share: Floats = np.mean([task.mean(axis=0) for task in above], axis=0)
    if not _has_spread(scores):
        nothing = np.full(len(thresholds), np.nan)
        return Profile(share, nothing, nothing)
    resampled = np.mean(
        [counts @ task / len(task) for counts, task in zip(_counts(scores), above, strict=True)],
        axis=0,
    )
    low, high = np.quantile(resampled, TAILS, axis=0)
    return Profile(share, low, high)


def probability_of_improvement(x: Scores, y: Scores, x_seeds: Seeds, y_seeds: Seeds) -> Estimate:
    """Return P(X > Y) over all pairs of runs.

    Where both have the same seeds in a task, a resample holds the same seeds of both.
    """
    value, resampled = 0.0, np.zeros(RESAMPLES)
    for task, (ours, theirs) in enumerate(zip(x, y, strict=True)):
        wins = _wins(ours[:, None], theirs[None, :])
        is_paired = x_seeds[task] == y_seeds[task]
        our_counts = draw_counts(len(ours), task)
        their_counts = draw_counts(len(theirs), task if is_paired else task + len(x))
        value += wins.mean() / len(x)
        resampled += ((our_counts @ wins) * their_counts).sum(axis=1) / wins.size / len(x)
    runs = [min(len(ours), len(theirs)) for ours, theirs in zip(x, y, strict=True)]
    return _share(value, resampled, runs)


def paired_probability_of_improvement(
    x: Scores, y: Scores, x_seeds: Seeds, y_seeds: Seeds
) -> Estimate | None:
    """Return P(X > Y) over the pairs of equal seed; None where a task has no such pair."""
    wins = []
    for task, (ours, theirs) in enumerate(zip(x, y, strict=True)):
        _, mine, other = np.intersect1d(x_seeds[task], y_seeds[task], return_indices=True)
        if not len(mine):
            return None
        wins.append(_wins(ours[mine], theirs[other]))
    resampled = np.mean(
        [counts @ task / len(task) for counts, task in zip(_counts(wins), wins, strict=True)],
        axis=0,
    )
    value = float(np.mean([task.mean() for task in wins]))
    return _share(value, resampled, [len(task) for task in wins])


def _share(value: float, resampled: Floats, counts: Sequence[int]) -> Estimate:
    """Return a share with its interval, of so many pairs in each task."""
    if np.ptp(resampled) > SAME or min(counts) < 2:
        return estimate(value, resampled, is_defined=min(counts) > 1)
    pairs = len(counts) ** 2 / sum(1 / n for n in counts)
    z2 = float(ndtri(TAILS[1])) ** 2
    middle = value + z2 / (2 * pairs)
    reach = math.sqrt(z2 * (value * (1 - value) / pairs + z2 / (4 * pairs**2)))
    low, high = ((middle + side * reach) / (1 + z2 / pairs) for side in (-1, 1))
    return Estimate(value, low, high)


def _middle_means(counts: Floats, ascending: Floats) -> Floats:
    """Return the IQM of each row of counts [r, N] of ascending values [N], rows summing to N.

    (scipy.stats.trim_mean of the values repeated, for all rows at once and without loading
    scipy.stats, which takes the service's start a second.)
    """
    runs = len(ascending)
    cut = int(TRIMMED * runs)
    drawn = np.cumsum(counts, axis=1)
    kept = np.minimum(drawn, runs - cut) - np.maximum(drawn - counts, cut)
    means: Floats = np.maximum(kept, 0.0) @ ascending / (runs - 2 * cut)
    return means


def _counts(scores: Scores) -> list[Floats]:
    return [draw_counts(len(values), task) for task, values in enumerate(scores)]


def _wins(x: Floats, y: Floats) -> Floats:
    wins: Floats = (x > y) + 0.5 * (x == y)
    return wins


def _has_spread(scores: Scores) -> bool:
    """Whether every task has runs to draw from: a single one would look certain."""
    return all(len(values) > 1 for values in scores)
