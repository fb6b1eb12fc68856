"""rliable's definitions (Agarwal et al., NeurIPS 2021), written out with scipy: an oracle.

Scores are [runs, tasks], as there. Its names: `aggregate_iqm`, `probability_of_improvement`,
`run_score_deviation`, and `StratifiedBootstrap` with percentiles.
"""

from collections.abc import Callable, Iterator

import numpy as np
import scipy.stats
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def aggregate_iqm(scores: Floats) -> float:
    return float(scipy.stats.trim_mean(scores, proportiontocut=0.25, axis=None))


def probability_of_improvement(x: Floats, y: Floats) -> float:
    tasks = []
    for ours, theirs in zip(x.T, y.T, strict=True):
        if np.array_equal(ours, theirs):
            tasks.append(0.5)
            continue
        u, _ = scipy.stats.mannwhitneyu(ours, theirs, alternative="greater")
        tasks.append(u / (len(ours) * len(theirs)))
    return float(np.mean(tasks))


def run_score_deviation(scores: Floats, threshold: float) -> float:
    return float(np.mean(scores > threshold))


def resampled(scores: Floats, times: int, seed: int) -> Iterator[Floats]:
    """Draw runs with replacement, in each task by itself."""
    draws = np.random.default_rng(seed)
    runs, tasks = scores.shape
    for _ in range(times):
        yield scores[draws.integers(runs, size=(runs, tasks)), np.arange(tasks)]


def interval(
    scores: Floats, statistic: Callable[[Floats], float], times: int = 2000, seed: int = 0
) -> tuple[float, float]:
    values = [statistic(each) for each in resampled(scores, times, seed)]
    low, high = np.percentile(values, [2.5, 97.5])
    return float(low), float(high)
