"""The mean rank of learners over tasks, with intervals of the stratified bootstrap.

    rank of learner i in a task = 1 + number of learners with a larger mean score there,
                                  equal ones counting half

A learner's mean is over the tasks in which it has scores; it is ranked among the learners that have
scores there too. A resample draws the runs of each task anew (service.analysis.statistics.
stratified_bootstrap), those of equal place of all learners together.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from service.analysis.curves import Floats
from service.analysis.statistics.stratified_bootstrap import (
    RESAMPLES,
    Estimate,
    draw_counts,
    estimate,
)


def mean_ranks(scores: Sequence[Mapping[str, Floats]]) -> list[Estimate]:
    """Return the mean rank of each learner, of its scores [n] by task; NaN for one without any."""
    tasks = list(dict.fromkeys(task for own in scores for task in own))
    rows = np.array([_task_ranks(scores, task, place) for place, task in enumerate(tasks)])
    return [
        _mean(rows[:, learner], is_defined=all(len(runs) > 1 for runs in own.values()))
        for learner, own in enumerate(scores)
    ]


def _task_ranks(scores: Sequence[Mapping[str, Floats]], task: str, place: int) -> Floats:
    """Return the ranks in a task [learners, 1 + RESAMPLES], the first of all runs."""
    means = np.full((len(scores), 1 + RESAMPLES), np.nan)
    for row, own in zip(means, scores, strict=True):
        if task in own:
            runs = own[task]
            row[0], row[1:] = runs.mean(), draw_counts(len(runs), place) @ runs / len(runs)
    return _ranks(means)


def _ranks(means: Floats) -> Floats:
    """Return the ranks [learners, k] in each column, NaN for NaN."""
    ahead = (means[None] > means[:, None]).sum(axis=1)
    equal = (means[None] == means[:, None]).sum(axis=1) - 1
    return np.where(np.isnan(means), np.nan, 1.0 + ahead + 0.5 * equal)


def _mean(ranks: Floats, *, is_defined: bool) -> Estimate:
    """Return the mean over tasks of one learner's ranks [tasks, 1 + RESAMPLES]."""
    there = ranks[~np.isnan(ranks[:, 0])]
    if not len(there):
        return Estimate(np.nan, np.nan, np.nan)
    means = there.mean(axis=0)
    return estimate(float(means[0]), means[1:], is_defined=is_defined)
