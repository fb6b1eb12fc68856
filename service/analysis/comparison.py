"""A sweep as its figure: a panel per environment, in it a curve per entry of the request.

Normalised return = (return - random) / (max_reward horizon - random), where random is the mean
return of uniform random actions: 0 acts at random, 1 is out of reach or perfect. While random has
not been measured the normalised values are not defined, and n is 0.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

from service.analysis.curves import Band, Curve, Floats, Series, aggregate
from service.model.processor import are_comparable
from service.model.request.entry import Entries, Entry
from service.model.run import RunStatus, unfinished
from service.model.run_curve import RETURNS, RunCurve
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec

Item = TypeVar("Item")
Key = TypeVar("Key")

Abscissa = Literal["timesteps", "updates", "jacobians", "seconds"]
MAX_TOTAL_POINTS = 500_000

BAND_TEXT: Mapping[Band, str] = {
    "std": "one standard deviation (ddof 1)",
    "ci95": "a 95 % confidence interval of the mean (Student's t)",
    "iqr": "the interquartile range (25 % to 75 %)",
}
SECONDS_TEXT = (
    "Seconds are processor time of acting and learning: waiting, compiling or loading kernels and "
    "evaluation are not in them."
)
NORMALISED_TEXT = (
    "Normalised: 0 is the mean return of uniform random actions, "
    "1 is the task's largest reward at every step."
)
ABSCISSA_TEXT: Mapping[Abscissa, str] = {
    "timesteps": "timesteps",
    "updates": "updates",
    "jacobians": "jacobians",
    "seconds": "processor seconds of training",
}
METRIC_TEXT = {
    "return_mean": "return_mean (undiscounted return of one evaluation episode)",
    "return_history": "return_history (mean of the latest 100 return_mean)",
}


@dataclass(frozen=True)
class View:
    """A view of a sweep: a metric over an abscissa, with a band, in a number of points.

    max_points   of a curve; fewer where all lines together would have more than MAX_TOTAL_POINTS
    algorithms   whose runs; empty: all
    environment  in which task; empty: all
    with_seeds   each run is a line of its own, beside the mean of its curve
    """

    metric: str
    normalized: bool
    band: Band
    x: Abscissa
    max_points: int
    algorithms: tuple[str, ...] = ()
    environment: str = ""
    with_seeds: bool = False

    def has(self, spec: RunSpec) -> bool:
        """Whether runs of that spec are in the view."""
        is_asked = not self.algorithms or spec.algorithm in self.algorithms
        return is_asked and self.environment in ("", spec.environment)

    def points(self, lines: int) -> int:
        """Return how many points each line may have, for a number of lines."""
        return min(self.max_points, max(2, MAX_TOTAL_POINTS // max(1, lines)))


@dataclass(frozen=True)
class SeedCurve:
    """One run of a curve."""

    seed: int
    run_id: str
    status: RunStatus
    values: Floats


@dataclass(frozen=True)
class LabelledCurve:
    """A curve, and its entry. `curve.values` [seeds, p] is in the order of `seeds`."""

    spec: RunSpec
    label: str
    curve: Curve
    seeds: tuple[SeedCurve, ...]

    @property
    def unfinished(self) -> dict[str, int]:
        """How many of the runs have not reached their end, by status."""
        return unfinished(seed.status for seed in self.seeds)


@dataclass(frozen=True)
class Panel:
    """The curves of one environment."""

    environment: str
    random_return: RandomReturn | None
    curves: tuple[LabelledCurve, ...]


@dataclass(frozen=True)
class Comparison:
    """A sweep seen through a view; `entries` are all of its request's, shown or not.

    `processors` are those that trained runs of the view.
    """

    view: View
    entries: tuple[Entry, ...]
    panels: tuple[Panel, ...]
    is_interpolated: bool
    processors: tuple[str, ...] = ()


def compare(
    run_curves: Sequence[RunCurve],
    entries: Entries,
    view: View,
    random_returns: Mapping[tuple[str, int], RandomReturn],
    best_return: Callable[[str], float],
) -> Comparison:
    """Return the comparison of those runs of a sweep that are in the view, in their order.

    `entries` are those of the sweep's request. `random_returns` are by (environment, version);
    `best_return(environment)` is max_reward times horizon.
    """
    shown = [run for run in run_curves if view.has(run.spec)]
    lines = {(run.spec.environment, entries.label(run)) for run in shown}
    points = view.points(len(shown) if view.with_seeds else len(lines))
    panels = []
    for environment, runs in grouped(shown, lambda run: run.spec.environment).items():
        zero = random_returns.get((environment, runs[0].environment_version))
        start, unit = scale(zero, best_return(environment)) if view.normalized else (0.0, 1.0)
        curves = [
            _curve(entry_runs, label, view.band, points, start, unit)
            for label, entry_runs in grouped(runs, entries.label).items()
        ]
        panels.append(Panel(environment, zero, tuple(curves)))
    is_interpolated = any(c.curve.is_interpolated for panel in panels for c in panel.curves)
    processors = sorted({run.processor for run in shown if len(run.x)})
    return Comparison(view, tuple(entries.all), tuple(panels), is_interpolated, tuple(processors))


def definition(comparisons: Sequence[Comparison]) -> str:
    """Say what curves show: statistic, band, n, normalisation, interpolation.

    Several comparisons differ in their metric alone.
    """
    view = comparisons[0].view
    metrics = [each.view.metric for each in comparisons]
    named = " and of ".join(METRIC_TEXT.get(metric, metric) for metric in metrics)
    sentences = [f"Mean and {BAND_TEXT[view.band]} over the n runs (seeds) of {named}."]
    if view.normalized:
        sentences.append(NORMALISED_TEXT)
    elif view.metric in RETURNS:
        sentences.append("Raw returns.")
    sentences.append("n counts the runs with a finite value there; no smoothing.")
    sentences.extend(filter(None, [_cut_short(comparisons[0])]))
    if view.x == "seconds":
        sentences.append(SECONDS_TEXT)
        sentences.extend(filter(None, [_unequal(comparisons[0].processors)]))
    if any(each.is_interpolated for each in comparisons):
        sentences.append(
            f"Runs were measured at different {view.x}: each is interpolated linearly between "
            "its own measurements."
        )
    return " ".join(sentences)


def _cut_short(comparison: Comparison) -> str:
    """Say which runs ended early: beyond their ends, the mean is of the others alone."""
    seeds = (seed for panel in comparison.panels for one in panel.curves for seed in one.seeds)
    short = unfinished(seed.status for seed in seeds if seed.status.is_final)
    if not short:
        return ""
    told = ", ".join(f"{number} {status}" for status, number in short.items())
    return f"Runs that did not reach their end ({told}) count as far as they were measured."


def _unequal(processors: Sequence[str]) -> str:
    """Say which processors trained the runs, unless all of their seconds can be compared."""
    if all(are_comparable(processors[0], each) for each in processors):
        return ""
    told = ", ".join(each or "not known" for each in processors)
    return (
        f"Processors that trained these runs: {told}; seconds of two processors differ in length."
    )


def scale(zero: RandomReturn | None, best_return: float) -> tuple[float, float]:
    """Return where the normalised scale starts and how long its unit is; NaN without a start."""
    if zero is None:
        return np.nan, np.nan
    return zero.mean, best_return - zero.mean


def _curve(
    runs: Sequence[RunCurve], label: str, band: Band, points: int, start: float, unit: float
) -> LabelledCurve:
    with np.errstate(all="ignore"):
        series = [Series(run.x, (run.values - start) / unit) for run in runs]
    curve = aggregate(series, band, points)
    seeds = tuple(
        SeedCurve(run.spec.seed, run.run_id, run.status, values)
        for run, values in zip(runs, curve.values, strict=True)
    )
    return LabelledCurve(runs[0].spec, label, curve, seeds)


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Group items, groups in the order of their first member."""
    groups: dict[Key, list[Item]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups
