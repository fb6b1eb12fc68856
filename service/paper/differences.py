"""The gain of a hybrid over what it extends, seed by seed, at equal cost of three kinds.

    d_i = 1/u (area of the hybrid's run i - area of the baseline's run i)

    area  mean of return_mean along the cost, up to the smaller of the costs that both runs reached
    u     the unit of the task's normalised scale, best minus random return

    timesteps    environment steps: what the paper's curves are drawn over
    evaluations  timesteps + Jacobians: a Jacobian counted as dear as a step (section 3.1)
    seconds      processor time of training (`algorithms.measurement.Measurement.seconds`)

The baseline has the settings chosen for it, which need not be the hybrid's, and the hybrid's form.
Only pairs count of which both runs reached their end, and at equal seconds only those on equal
processors; pairs with a failed or diverged run are reported.

    interval               95 % of the mean of d, percentile bootstrap over the pairs, of this task
    p                      of the sign-flip test (service.analysis.statistics.sign_flips)
    corrected p            Holm's, over the tasks of the family, at the same cost
    simultaneous interval  Student's t at 1 - 0.05/m, m tasks of the family: with 95 % confidence
                           all m hold the true means at once (Bonferroni)

The paper's seven tasks are a family, and those beyond them another. A task of a family that has no
pairs yet counts as a test, too, so that corrected values do not change when it has some.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from service.analysis.comparison import grouped
from service.analysis.curves import Floats
from service.analysis.statistics.holm import holm
from service.analysis.statistics.paired_difference import area_gained
from service.analysis.statistics.sample import Sample, sample
from service.analysis.statistics.sign_flips import sign_flip_p
from service.analysis.statistics.stratified_bootstrap import Estimate, draw_counts, estimate
from service.model.processor import are_comparable
from service.paper.evaluation import MORE_TASKS, TASKS
from service.paper.measured import EARLY, ENDED, Columns, MeasuredRun, Scale
from workers.messages.run_spec import NO_WEIGHTS, Weights

COSTS: Mapping[str, Callable[[Columns], Floats]] = {
    "timesteps": lambda run: run["timestep"],
    "evaluations": lambda run: run["timestep"] + run["jacobians"],
    "seconds": lambda run: run["seconds"],
}
FAMILIES: tuple[Sequence[str], ...] = (TASKS, MORE_TASKS)
ERROR = 0.05
"""The probability of a false finding in a family."""


@dataclass(frozen=True)
class Gain:
    """The mean of d over n pairs.

    Attributes:
        wins: pairs with d above 0.
        failed: pairs that do not count because a run failed, diverged or was cancelled.
        mean: with the interval of this task alone.
        simultaneous: the same mean with the interval of all tasks of the family at once.
        p: of the sign-flip test.
        corrected_p: the same after Holm.
    """

    environment: str
    algorithm: str
    weights: Weights
    cost: str
    n: int
    wins: int
    failed: int
    mean: Estimate
    simultaneous: Sample
    p: float
    corrected_p: float

    @property
    def verdict(self) -> str:
        """The result of the corrected test."""
        if not self.corrected_p <= ERROR:
            return "not told apart"
        return "better" if self.mean.value > 0 else "behind"


def gains(runs: Sequence[MeasuredRun], scales: Mapping[str, Scale]) -> list[Gain]:
    """Return the gains of every hybrid whose baseline was run, task by task.

    Tasks that belong to no family, as MassPoint, have none.
    """
    return [gain for family in FAMILIES for gain in _family(runs, scales, family)]


def mean_gain(d: Floats) -> Estimate:
    """Return the mean of d [n] with its interval; NaN where n is too small for it."""
    if not d.size:
        return Estimate(np.nan, np.nan, np.nan)
    resampled = draw_counts(d.size, stratum=0) @ d / d.size
    return estimate(float(d.mean()), resampled, is_defined=d.size > 1)


def _family(
    runs: Sequence[MeasuredRun], scales: Mapping[str, Scale], family: Sequence[str]
) -> list[Gain]:
    """Return the gains in a family's tasks, corrected for their number."""
    cells = grouped(
        [run for run in runs if run.environment in family and run.environment in scales],
        lambda run: (run.environment, run.row, run.weights),
    )
    found = [
        gain
        for (environment, *_), ours in cells.items()
        for theirs in [cells.get((environment, ours[0].baseline, NO_WEIGHTS), [])]
        for gain in _cell(ours, theirs, scales[environment].unit, len(family))
    ]
    tests = grouped(found, lambda gain: (gain.algorithm, gain.cost)).values()
    corrected = [gain for test in tests for gain in _corrected(test, len(family))]
    return sorted(corrected, key=lambda gain: family.index(gain.environment))


def _corrected(gains: Sequence[Gain], tests: int) -> Iterator[Gain]:
    """Yield the gains of a hybrid at one cost with the p corrected, for at least so many tests."""
    corrected = holm([gain.p for gain in gains], max(tests, len(gains)))
    for gain, p in zip(gains, corrected, strict=True):
        yield replace(gain, corrected_p=float(p))


def _cell(
    ours: Sequence[MeasuredRun], theirs: Sequence[MeasuredRun], unit: float, tests: int
) -> Iterator[Gain]:
    """Yield the gains of a hybrid's runs over its baseline's at each cost, p not corrected yet."""
    by_seed = {run.seed: run for run in theirs}
    pairs = [(run, by_seed[run.seed]) for run in ours if run.seed in by_seed]
    ended = [pair for pair in pairs if all(run.status == ENDED for run in pair)]
    failed = sum(any(run.status in EARLY for run in pair) for pair in pairs)
    of = ours[0]
    for cost, spent in COSTS.items() if ended or failed else ():
        same = [
            (a, b)
            for a, b in ended
            if cost != "seconds" or are_comparable(a.processor, b.processor)
        ]
        d = np.array([_difference(spent, *pair) for pair in same]) / unit
        d = d[np.isfinite(d)]
        wins, p = int((d > 0).sum()), sign_flip_p(d)
        at_once = sample(d, 1 - ERROR / tests)
        yield Gain(
            of.environment, of.algorithm, of.weights, cost, d.size, wins, failed,
            mean_gain(d), at_once, p, p,
        )  # fmt: skip


def _difference(
    cost: Callable[[Columns], Floats], run: MeasuredRun, baseline: MeasuredRun
) -> float:
    ours, theirs = run.columns, baseline.columns
    return area_gained(cost(ours), ours["return_mean"], cost(theirs), theirs["return_mean"])
