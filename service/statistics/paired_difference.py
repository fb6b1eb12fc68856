"""What an algorithm gains over the one it extends, seed by seed, in each task.

    d_i = 1/u (area of the hybrid's run i - area of the baseline's run i)
    area = 1/(t_1 - t_0) integral of return_mean over timesteps t_0 ... t_1 (trapezoids)

    u    the unit of the task's normalised scale, best minus random return
    t_0  the run's first measurement    t_1  the last timestep that both runs of the pair measured

Runs of equal seed start from the same networks and the same states, so that their difference is
known better than the difference of the means. Pairs with a value that is not finite do not count.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from service.comparison import grouped, label_cells, scale
from service.curves import Floats
from service.run_curve import RunCurve
from service.statistics.sample import Sample, sample
from service.statistics.score import area
from workers.random_return import RandomReturn

BASELINES = {"hybrid-ddpg": "ddpg", "hybrid-ddpg-cosine": "ddpg", "hybrid-sac": "sac"}


@dataclass(frozen=True)
class PairedDifference:
    """A curve minus its baseline's in one environment; `wins` of the n pairs are above 0."""

    environment: str
    label: str
    baseline: str
    difference: Sample
    wins: int


def paired_differences(
    run_curves: Sequence[RunCurve],
    random_returns: Mapping[tuple[str, int], RandomReturn],
    best_return: Callable[[str], float],
) -> list[PairedDifference]:
    """Return the differences of a sweep's runs of return_mean over timesteps."""
    cells = grouped(run_curves, lambda run: run.spec.cell)
    labels = label_cells({cell: runs[0].spec for cell, runs in cells.items()})
    found = []
    for cell, runs in cells.items():
        zero = random_returns.get((cell.environment, runs[0].environment_version))
        _, unit = scale(zero, best_return(cell.environment))
        for other, baseline_runs in cells.items():
            if (other.environment, other.algorithm) == (
                cell.environment,
                BASELINES.get(cell.algorithm),
            ):
                gained = _differences(runs, baseline_runs) / unit
                gained = gained[np.isfinite(gained)]
                found.append(
                    PairedDifference(
                        cell.environment,
                        labels[cell],
                        labels[other],
                        sample(gained),
                        int((gained > 0).sum()),
                    )
                )
    return found


def _differences(runs: Sequence[RunCurve], baseline_runs: Sequence[RunCurve]) -> Floats:
    """Return the differences of area of the pairs of equal seed; NaN before both have measured."""
    by_seed = {run.spec.seed: run for run in baseline_runs}
    pairs = [(run, by_seed[run.spec.seed]) for run in runs if run.spec.seed in by_seed]
    return np.array([area_gained(run.x, run.values, its.x, its.values) for run, its in pairs])


def area_gained(x: Floats, y: Floats, x0: Floats, y0: Floats) -> float:
    """Return the area of (x, y) minus that of (x0, y0), both up to the smaller of their last x.

    NaN where one of them has no point up to there.
    """
    if not (len(x) and len(x0)):
        return np.nan
    end = min(x[-1], x0[-1])
    ours, theirs = x <= end, x0 <= end
    if not (ours.any() and theirs.any()):
        return np.nan
    return area(x[ours], y[ours]) - area(x0[theirs], y0[theirs])
