"""Scores of a sweep: what each run reached, by entry and environment.

Only a run that reached its end has a score: one that goes on is not comparable yet, and one that
failed, diverged or was cancelled never will be. NaN stands for those, and for a score that is not
finite or whose environment has no random return yet. A cell is complete when every run of it has a
score. An incomplete cell has the mean of the runs that did not fail, and seeds that fail are seldom
the good ones: it may be shown, with the number of its runs, but is never the best.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from service.analysis.comparison import grouped, scale
from service.analysis.curves import Floats
from service.analysis.statistics.score import SCORES, Score
from service.model.request.entry import Entries
from service.model.run import RunStatus, unfinished
from service.model.run_curve import RunCurve
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec


@dataclass(frozen=True)
class CellScores:
    """The scores of the runs of one entry in one environment.

    place     of the entry in its request
    seeds     of its runs, ascending
    values    [runs] in the order of `seeds`
    statuses  of the runs, in that order
    """

    spec: RunSpec
    label: str
    place: int
    seeds: tuple[int, ...]
    values: Floats
    statuses: tuple[RunStatus, ...]

    @property
    def is_complete(self) -> bool:
        """Whether every run has a score."""
        return bool(np.isfinite(self.values).all())

    @property
    def unfinished(self) -> dict[str, int]:
        """How many runs have not reached their end, by status."""
        return unfinished(self.statuses)


def sweep_scores(
    run_curves: Sequence[RunCurve],
    entries: Entries,
    score: Score,
    random_returns: Mapping[tuple[str, int], RandomReturn],
    best_return: Callable[[str], float],
    *,
    normalized: bool,
) -> list[CellScores]:
    """Return the scores of a sweep, cells in the order of its runs.

    The curves are those of the score's own metric over timesteps.
    """
    cells = grouped(run_curves, lambda run: (run.spec.environment, entries.label(run)))
    scores = []
    for (environment, label), runs in cells.items():
        start, unit = 0.0, 1.0
        if normalized:
            zero = random_returns.get((environment, runs[0].environment_version))
            start, unit = scale(zero, best_return(environment))
        ascending = sorted(runs, key=lambda run: run.spec.seed)
        values = (np.array([_score(run, score) for run in ascending]) - start) / unit
        values[~np.isfinite(values)] = np.nan
        scores.append(
            CellScores(
                spec=ascending[0].spec,
                label=label,
                place=ascending[0].entry,
                seeds=tuple(run.spec.seed for run in ascending),
                values=values,
                statuses=tuple(run.status for run in ascending),
            )
        )
    return scores


def labels_of(cells: Sequence[CellScores]) -> list[str]:
    """Return the names of the cells' entries, each once, in the order of the request."""
    return list(dict.fromkeys(cell.label for cell in sorted(cells, key=lambda cell: cell.place)))


def _score(run: RunCurve, score: Score) -> float:
    if run.status is not RunStatus.SUCCEEDED or not len(run.values):
        return np.nan
    return SCORES[score].of(run.x, run.values, run.spec.timesteps)
