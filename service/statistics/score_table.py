"""The paper's table 1 for any sweep: a row per algorithm and its settings, a column per task.

An entry holds mean, standard deviation (ddof 1) and the 95 % interval of the mean (Student's t)
of its runs' scores. The best of a column are the largest mean, and those that are equal to it when
both are rounded as they are printed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from service.comparison import METRIC_TEXT, NORMALISED_TEXT
from service.statistics.sample import Sample, sample
from service.statistics.scores import CellScores
from workers.run_spec import RunSpec


@dataclass(frozen=True)
class Entry:
    """One cell of a sweep: its scores, all of its runs, and how many of them are final."""

    spec: RunSpec
    sample: Sample
    runs: int
    ended: int
    is_best: bool


@dataclass(frozen=True)
class Row:
    """The entries of one label, in the order of the environments; None where there are no runs."""

    label: str
    entries: tuple[Entry | None, ...]


@dataclass(frozen=True)
class ScoreTable:
    """Rows and columns in the order of the sweep's runs."""

    metric: str
    normalized: bool
    environments: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def decimals(self) -> int:
        """Digits after the point that are printed, and that bold type goes by."""
        return decimals(normalized=self.normalized)

    @property
    def definition(self) -> str:
        """What the table shows, in words."""
        entries = [entry for row in self.rows for entry in row.entries if entry]
        runs, ended = sum(entry.runs for entry in entries), sum(entry.ended for entry in entries)
        still = f" {runs - ended} of {runs} runs have not ended: their scores may change."
        return (
            "Mean, standard deviation (ddof 1) and 95 % confidence interval of the mean "
            "(Student's t) over the n runs (seeds) of the latest "
            f"{METRIC_TEXT[self.metric]}. {NORMALISED_TEXT if self.normalized else 'Raw returns.'} "
            "n counts the runs with a finite value. Bold: the largest mean of its environment, and "
            f"those equal to it when rounded to {self.decimals} decimals."
            f"{still if ended < runs else ''}"
        )


def score_table(scores: Sequence[CellScores], metric: str, *, normalized: bool) -> ScoreTable:
    """Return the table of a sweep's scores."""
    samples = [(cell, sample(cell.values)) for cell in scores]
    best = _best_means(samples, decimals(normalized=normalized))
    entries = {
        (cell.label, cell.spec.environment): Entry(
            cell.spec,
            summary,
            runs=len(cell.seeds),
            ended=cell.ended,
            is_best=round(summary.mean, decimals(normalized=normalized))
            == best.get(cell.spec.environment),
        )
        for cell, summary in samples
    }
    labels = dict.fromkeys(cell.label for cell in scores)
    environments = tuple(dict.fromkeys(cell.spec.environment for cell in scores))
    rows = [
        Row(label, tuple(entries.get((label, environment)) for environment in environments))
        for label in labels
    ]
    return ScoreTable(metric, normalized, environments, tuple(rows))


def decimals(*, normalized: bool) -> int:
    """How many digits after the point a mean is printed with."""
    return 3 if normalized else 2


def _best_means(samples: Sequence[tuple[CellScores, Sample]], digits: int) -> dict[str, float]:
    """The largest rounded mean of each environment that has one."""
    best: dict[str, float] = {}
    for cell, summary in samples:
        if math.isfinite(summary.mean):
            environment = cell.spec.environment
            rounded = round(summary.mean, digits)
            best[environment] = max(best.get(environment, rounded), rounded)
    return best
