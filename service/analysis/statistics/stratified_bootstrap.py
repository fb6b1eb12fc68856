"""The stratified bootstrap: intervals of a statistic of many tasks' runs.

Runs are drawn with replacement within each task (stratum), so every resample has the tasks and the
numbers of runs of the sweep; the 95 % interval lies between the 2.5 % and 97.5 % quantiles of the
statistic over the resamples (the percentile bootstrap; Agarwal et al., NeurIPS 2021).

A resample is kept as counts: how often each run of a task was drawn, [RESAMPLES, n]. They come of
a fixed generator, and so depend on a task's place and number of runs alone: the same data give the
same interval, and one algorithm's interval does not move with the company it is shown in.
"""

import math
import threading
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from cachetools import LRUCache, cached
from numpy.typing import NDArray

from physics.randomness import generator
from service.analysis.curves import Floats

RESAMPLES = 2000
TAILS = (0.025, 0.975)


@dataclass(frozen=True)
class Estimate:
    """A statistic and its 95 % interval; NaN where a task has a single run, or none."""

    value: float
    low: float
    high: float


def _bytes(counts: NDArray[np.uint16]) -> int:
    return counts.nbytes


kept_counts: LRUCache[Hashable, NDArray[np.uint16]] = LRUCache(2**25, getsizeof=_bytes)
"""The counts that were drawn last, as small as they are exact, in 34 megabytes."""


@cached(kept_counts, lock=threading.Lock())
def _drawn(runs: int, stratum: int) -> NDArray[np.uint16]:
    draws = generator(0, "stratified bootstrap", stratum)
    return draws.multinomial(runs, np.full(runs, 1 / runs), size=RESAMPLES).astype(np.uint16)


def draw_counts(runs: int, stratum: int) -> Floats:
    """Return how often each of a task's runs was drawn [RESAMPLES, runs]; rows sum to `runs`."""
    return _drawn(runs, stratum).astype(np.float64)


def estimate(value: float, resampled: Floats, *, is_defined: bool) -> Estimate:
    """Return a statistic with the quantiles of its resamples [RESAMPLES]."""
    if not is_defined:
        return Estimate(value, math.nan, math.nan)
    low, high = np.quantile(resampled, TAILS)
    return Estimate(value, float(low), float(high))
