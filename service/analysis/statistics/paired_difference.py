"""The gain of an entry over one of the algorithm that its own extends, by seed and task.

    d_i = 1/u (area of the hybrid's run i - area of the baseline's run i)
    area = 1/(t_1 - t_0) integral of return_mean over timesteps t_0 ... t_1 (trapezoids)

    u    the unit of the task's normalised scale, best minus random return
    t_0  the run's first measurement    t_1  the last timestep that both runs of the pair measured

Runs of equal seed start from the same networks and the same states, so that their difference is
known better than the difference of the means. Only pairs count in which both runs reached their end
and no value is other than finite.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from algorithms import catalogue
from service.analysis.comparison import grouped, scale
from service.analysis.curves import Floats
from service.analysis.statistics.sample import Sample, sample
from service.analysis.statistics.score import area
from service.model.request.entry import Entries
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from workers.messages.random_return import RandomReturn


@dataclass(frozen=True)
class PairedDifference:
    """An entry minus its baseline in one environment.

    pairs       of equal seed there are
    difference  of the n pairs that count
    wins        those of them above 0
    """

    environment: str
    label: str
    baseline: str
    pairs: int
    difference: Sample
    wins: int


def paired_differences(
    run_curves: Sequence[RunCurve],
    entries: Entries,
    random_returns: Mapping[tuple[str, int], RandomReturn],
    best_return: Callable[[str], float],
    reference: str | None = None,
) -> list[PairedDifference]:
    """Return the differences of a sweep's runs of return_mean over timesteps.

    With a `reference`, the label of an entry, every other entry is compared with that one.
    """
    cells = grouped(run_curves, lambda run: (run.spec.environment, entries.label(run)))
    found = []
    for (environment, label), runs in cells.items():
        zero = random_returns.get((environment, runs[0].environment_version))
        _, unit = scale(zero, best_return(environment))
        extended = catalogue.baseline(runs[0].spec.algorithm)
        for (other_environment, baseline), its_runs in cells.items():
            is_meant = (
                its_runs[0].spec.algorithm == extended
                if reference is None
                else baseline == reference != label
            )
            if other_environment == environment and is_meant:
                gained = _differences(runs, its_runs) / unit
                counted = gained[np.isfinite(gained)]
                wins = int((counted > 0).sum())
                found.append(
                    PairedDifference(
                        environment, label, baseline, len(gained), sample(counted), wins
                    )
                )
    return found


def _differences(runs: Sequence[RunCurve], baseline_runs: Sequence[RunCurve]) -> Floats:
    """Return the differences of area of the pairs of equal seed; NaN for those not at their end."""
    by_seed = {run.spec.seed: run for run in baseline_runs}
    pairs = [(run, by_seed[run.spec.seed]) for run in runs if run.spec.seed in by_seed]
    return np.array([_difference(*pair) for pair in pairs])


def _difference(run: RunCurve, its: RunCurve) -> float:
    if {run.status, its.status} != {RunStatus.SUCCEEDED}:
        return np.nan
    return area_gained(run.x, run.values, its.x, its.values)


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
