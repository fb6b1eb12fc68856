"""What a hybrid gains over what it extends, seed by seed, at equal cost; costs are of three kinds.

    d_i = 1/u (area of the hybrid's run i - area of the baseline's run i)

    area  mean of return_mean along the cost, up to the smaller of the costs that both runs reached
    u     the unit of the task's normalised scale, best minus random return

    timesteps    environment steps: what the paper's curves are drawn over
    evaluations  timesteps + Jacobians: a Jacobian counted as dear as a step (section 3.1)
    seconds      processor time of training (`algorithms.measurement.Measurement.seconds`)

Interval: 95 % of the mean of d, percentile bootstrap over the pairs. Only runs that reached their
end are given: pairs of which one did not are not counted.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from algorithms import catalogue
from service.analysis.curves import Floats
from service.analysis.statistics.paired_difference import area_gained
from service.analysis.statistics.stratified_bootstrap import Estimate, draw_counts, estimate
from workers.messages.run_spec import NO_WEIGHTS, Weights

Columns = Mapping[str, Floats]

COSTS: Mapping[str, Callable[[Columns], Floats]] = {
    "timesteps": lambda run: run["timestep"],
    "evaluations": lambda run: run["timestep"] + run["jacobians"],
    "seconds": lambda run: run["seconds"],
}


@dataclass(frozen=True)
class MeasuredRun:
    """A run with its measurements, column by column [n]."""

    algorithm: str
    environment: str
    weights: Weights
    seed: int
    columns: Columns


@dataclass(frozen=True)
class Gain:
    """The mean of d over n pairs, `wins` of them above 0."""

    environment: str
    algorithm: str
    weights: Weights
    cost: str
    n: int
    wins: int
    mean: Estimate


def gains(runs: Sequence[MeasuredRun], units: Mapping[str, float]) -> Iterator[Gain]:
    """Yield the gains of every hybrid whose baseline was run; `units` by environment."""
    cells: dict[tuple[str, str, Weights], list[MeasuredRun]] = {}
    for run in runs:
        cells.setdefault((run.environment, run.algorithm, run.weights), []).append(run)
    for (environment, algorithm, weights), ours in cells.items():
        baseline = catalogue.baseline(algorithm)
        theirs = {run.seed: run for run in cells.get((environment, baseline, NO_WEIGHTS), ())}
        pairs = [(run, theirs[run.seed]) for run in ours if run.seed in theirs]
        for cost, of in COSTS.items() if pairs else ():
            d = np.array([_difference(of, *pair) for pair in pairs]) / units[environment]
            d = d[np.isfinite(d)]
            wins = int((d > 0).sum())
            yield Gain(environment, algorithm, weights, cost, d.size, wins, mean_gain(d))


def mean_gain(d: Floats) -> Estimate:
    """Return the mean of d [n] with its interval; NaN where n is too small for it."""
    if not d.size:
        return Estimate(np.nan, np.nan, np.nan)
    resampled = draw_counts(d.size, stratum=0) @ d / d.size
    return estimate(float(d.mean()), resampled, is_defined=d.size > 1)


def _difference(
    cost: Callable[[Columns], Floats], run: MeasuredRun, baseline: MeasuredRun
) -> float:
    ours, theirs = run.columns, baseline.columns
    return area_gained(cost(ours), ours["return_mean"], cost(theirs), theirs["return_mean"])
