"""Scores: the return each run of a sweep has reached, by curve and environment.

A run's score is the latest value it measured, normalised where that is asked for (see
`service.comparison`). Runs that go on have one too, so scores of a sweep that is not finished are
those of now. NaN stands for a run that measured nothing yet, whose latest value is not finite, or
whose environment has no random return yet.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from service.comparison import grouped, label_cells, scale
from service.curves import Floats
from service.run_curve import RunCurve
from workers.random_return import RandomReturn
from workers.run_spec import RunSpec


@dataclass(frozen=True)
class CellScores:
    """The scores of the runs of one cell.

    seeds   of its runs, ascending
    values  [runs] in the order of `seeds`
    ended   how many of the runs are final
    """

    spec: RunSpec
    label: str
    seeds: tuple[int, ...]
    values: Floats
    ended: int


def latest_scores(
    run_curves: Sequence[RunCurve],
    random_returns: Mapping[tuple[str, int], RandomReturn],
    best_return: Callable[[str], float],
    *,
    normalized: bool,
) -> list[CellScores]:
    """Return the scores of a sweep, cells in the order of its runs."""
    labels = label_cells({run.spec.cell: run.spec for run in run_curves})
    scores = []
    for cell, runs in grouped(run_curves, lambda run: run.spec.cell).items():
        start, unit = 0.0, 1.0
        if normalized:
            zero = random_returns.get((cell.environment, runs[0].environment_version))
            start, unit = scale(zero, best_return(cell.environment))
        ascending = sorted(runs, key=lambda run: run.spec.seed)
        latest = np.array([run.values[-1] if len(run.values) else np.nan for run in ascending])
        values = (latest - start) / unit
        values[~np.isfinite(values)] = np.nan
        scores.append(
            CellScores(
                spec=ascending[0].spec,
                label=labels[cell],
                seeds=tuple(run.spec.seed for run in ascending),
                values=values,
                ended=sum(run.status.is_final for run in runs),
            )
        )
    return scores
