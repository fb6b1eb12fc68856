"""Learners over many tasks: how far they are after a share of the timesteps, and of the time.

Curves of different tasks have one scale each: returns are normalised, and timesteps and processor
time are shares of what a reference learner takes in that task. The value of a run at a point is
interpolated linearly between its measurements; there is none before the first, and after the last
it stays, as the policy does.

    line  interquartile mean, at each point, of all runs of all tasks that a learner ran in
          (service.analysis.statistics.score_statistics); none where a run has no value yet
    rank  mean rank over tasks (service.analysis.statistics.mean_rank) by the mean of a run's values
          at all shares of the timesteps
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from algorithms.threads import one_thread
from service.analysis.curves import Floats
from service.analysis.statistics.mean_rank import mean_ranks
from service.analysis.statistics.score_statistics import interquartile_mean
from service.analysis.statistics.stratified_bootstrap import Estimate

SHARES = np.linspace(0.04, 1.0, 25)
"""Of the timesteps; the first measurement of 20,000 timesteps is at 0.04."""
TIMES = np.geomspace(0.05, 5.0, 41)
"""Of the processor time."""


@dataclass(frozen=True)
class SharedRun:
    """A run with its measurements [n]: shares of timesteps and of time, and normalised returns.

    Shares of time are NaN if the reference's time on the run's machine is not known.
    """

    timesteps: Floats
    time: Floats
    returns: Floats


@dataclass(frozen=True)
class Learner:
    """A learner's runs that reached their end, by task; each task has at least one.

    `early` runs failed, diverged or were cancelled, and do not count.
    """

    label: str
    algorithm: str
    runs: Mapping[str, Sequence[SharedRun]]
    early: int = 0


@dataclass(frozen=True)
class Line:
    """Interquartile means with their 95 % intervals along x, each [k]."""

    x: Floats
    mean: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class Standing:
    """Where a learner stands over its tasks."""

    label: str
    algorithm: str
    tasks: int
    runs: int
    early: int
    by_timesteps: Line
    by_time: Line
    rank: Estimate


def standings(learners: Sequence[Learner]) -> list[Standing]:
    """Return where each learner stands."""
    with one_thread():  # the products are small, and their bits are not to depend on the cores
        ranks = mean_ranks([_areas(learner) for learner in learners])
        return [
            Standing(
                learner.label,
                learner.algorithm,
                len(learner.runs),
                sum(map(len, learner.runs.values())),
                learner.early,
                _line(SHARES, [_at_shares(runs) for runs in learner.runs.values()]),
                _line(TIMES, [_at_times(runs) for runs in learner.runs.values()]),
                rank,
            )
            for learner, rank in zip(learners, ranks, strict=True)
        ]


def _areas(learner: Learner) -> dict[str, Floats]:
    """The mean value of each run [n] over the shares of the timesteps, by task."""
    return {task: np.nanmean(_at_shares(runs), axis=1) for task, runs in learner.runs.items()}


def _at_shares(runs: Sequence[SharedRun]) -> Floats:
    """Values [n, k] at the shares of the timesteps."""
    return np.array([_values(SHARES, run.timesteps, run.returns) for run in runs])


def _at_times(runs: Sequence[SharedRun]) -> Floats:
    """Values [n, k] at the shares of the time."""
    return np.array([_values(TIMES, run.time, run.returns) for run in runs])


def _values(at: Floats, x: Floats, y: Floats) -> Floats:
    """Values at points [k] of a run measured at x [n]."""
    return np.interp(at, x, y, left=np.nan)


def _line(x: Floats, values: Sequence[Floats]) -> Line:
    """The line of values [n, k] in each task."""
    is_known = np.isfinite(np.concatenate(values)).all(axis=0)
    estimates = [
        interquartile_mean([task[:, point] for task in values])
        for point in np.flatnonzero(is_known)
    ]
    columns = [[getattr(each, name) for each in estimates] for name in ("value", "low", "high")]
    mean, low, high = (np.array(column, np.float64) for column in columns)
    return Line(x[is_known], mean, low, high)
