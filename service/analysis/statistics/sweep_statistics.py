"""The statistics of one sweep, over the tasks that all its entries have in common.

Not every entry runs in every task, and means over different tasks cannot be compared: only tasks in
which every entry has a finite score count. An entry without any score yet is left out. Where only
some runs of a cell have a score, those count, and the cell is named.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from algorithms.threads import one_thread
from service.analysis.comparison import grouped
from service.analysis.curves import Floats
from service.analysis.statistics.score_statistics import (
    Profile,
    interquartile_mean,
    paired_probability_of_improvement,
    performance_profile,
    probability_of_improvement,
)
from service.analysis.statistics.scores import CellScores, labels_of
from service.analysis.statistics.stratified_bootstrap import Estimate

THRESHOLDS = 101
LOWEST_THRESHOLD = -1.0


@dataclass(frozen=True)
class LabelStatistics:
    """One entry's scores in the common tasks; `runs` is how many finite ones there are."""

    label: str
    algorithm: str
    runs: int
    iqm: Estimate
    profile: Profile


@dataclass(frozen=True)
class Improvement:
    """How probably a run of x beats one of y: over all pairs, and over pairs of equal seed."""

    x: str
    y: str
    all_pairs: Estimate
    same_seeds: Estimate | None


@dataclass(frozen=True)
class SweepStatistics:
    """The statistics over the common `tasks`.

    lacking     by task that is not common: the labels without a score in it
    unscored    labels without a score in any task; they are left out
    incomplete  cells of the common tasks in which some runs have no score
    thresholds  [k], of the profiles
    """

    tasks: tuple[str, ...]
    lacking: dict[str, list[str]]
    unscored: tuple[str, ...]
    incomplete: tuple[CellScores, ...]
    labels: tuple[LabelStatistics, ...]
    improvements: tuple[Improvement, ...]
    thresholds: Floats


@dataclass(frozen=True)
class _Scored:
    """One label's finite scores and their seeds, task by task."""

    label: str
    algorithm: str
    scores: tuple[Floats, ...]
    seeds: tuple[tuple[int, ...], ...]


def sweep_statistics(cells: Sequence[CellScores]) -> SweepStatistics:
    """Return the statistics of a sweep's scores."""
    by_label = grouped([cell for cell in cells if _finite(cell).any()], lambda cell: cell.label)
    unscored = [label for label in labels_of(cells) if label not in by_label]
    covered = {
        label: {cell.spec.environment: cell for cell in by_label[label]}
        for label in labels_of(cells)
        if label in by_label
    }
    lacking = {
        task: [label for label, own in covered.items() if task not in own]
        for task in dict.fromkeys(cell.spec.environment for cell in cells)
    }
    tasks = tuple(task for task, without in lacking.items() if not without and covered)
    scored = [_scored(label, [own[task] for task in tasks]) for label, own in covered.items()]
    thresholds = _thresholds(scored) if tasks else np.empty(0)
    with one_thread():  # the products are small, and their bits are not to depend on the cores
        labels = tuple(_label_statistics(one, thresholds) for one in scored if tasks)
        improvements = tuple(_improvement(x, y) for x, y in combinations(scored, 2) if tasks)
    return SweepStatistics(
        tasks=tasks,
        lacking={task: without for task, without in lacking.items() if task not in tasks},
        unscored=tuple(unscored),
        incomplete=tuple(
            cell
            for own in covered.values()
            for task, cell in own.items()
            if task in tasks and not cell.is_complete
        ),
        labels=labels,
        improvements=improvements,
        thresholds=thresholds,
    )


def _finite(cell: CellScores) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    return np.isfinite(cell.values)


def _scored(label: str, cells: Sequence[CellScores]) -> _Scored:
    return _Scored(
        label,
        cells[0].spec.algorithm if cells else "",
        tuple(cell.values[_finite(cell)] for cell in cells),
        tuple(
            tuple(seed for seed, known in zip(cell.seeds, _finite(cell), strict=True) if known)
            for cell in cells
        ),
    )


def _thresholds(scored: Sequence[_Scored]) -> Floats:
    """Evenly from the lowest score, 0 at most and -1 at least, to the highest, at least 1."""
    values = np.concatenate([task for one in scored for task in one.scores])
    lowest = max(min(float(values.min()), 0.0), LOWEST_THRESHOLD)
    return np.linspace(lowest, max(float(values.max()), 1.0), THRESHOLDS)


def _label_statistics(one: _Scored, thresholds: Floats) -> LabelStatistics:
    return LabelStatistics(
        one.label,
        one.algorithm,
        sum(map(len, one.scores)),
        interquartile_mean(one.scores),
        performance_profile(one.scores, thresholds),
    )


def _improvement(x: _Scored, y: _Scored) -> Improvement:
    both = (x.scores, y.scores, x.seeds, y.seeds)
    return Improvement(
        x.label,
        y.label,
        probability_of_improvement(*both),
        paired_probability_of_improvement(*both),
    )
