"""The scores of every entry of a sweep in every task: a row an entry, a column a task.

A cell holds mean, standard deviation (ddof 1) and the 95 % interval of the mean (Student's t) of
the scores of its runs that reached their end. The best of a column is the largest mean of the
cells in which every run did, and those that are equal to it when both are rounded as they are
printed. With `return_history` for the score it is the paper's table 1.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from service.analysis.comparison import NORMALISED_TEXT
from service.analysis.statistics.sample import Sample, sample
from service.analysis.statistics.score import SCORES, Score
from service.analysis.statistics.scores import CellScores, labels_of
from workers.messages.run_spec import RunSpec


@dataclass(frozen=True)
class Standing:
    """One cell: the sample of its scores, how many runs it has, and which are not at their end."""

    spec: RunSpec
    sample: Sample
    runs: int
    unfinished: Mapping[str, int]
    is_best: bool


@dataclass(frozen=True)
class Row:
    """The standings of one entry, environment by environment; None where there are no runs."""

    label: str
    standings: tuple[Standing | None, ...]


@dataclass(frozen=True)
class ScoreTable:
    """Rows in the order of the request, columns in that of the sweep's runs."""

    score: Score
    normalized: bool
    environments: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def decimals(self) -> int:
        """Digits after the point that are printed, and that decide on bold type."""
        return decimals(normalized=self.normalized)

    @property
    def definition(self) -> str:
        """What the table shows, in words."""
        return (
            "Mean, standard deviation (ddof 1) and 95 % confidence interval of the mean "
            "(Student's t) over the n runs (seeds) that reached their end, of "
            f"{SCORES[self.score].text}. {NORMALISED_TEXT if self.normalized else 'Raw returns.'} "
            "Bold: the largest mean of its environment, and those equal to it when rounded to "
            f"{self.decimals} decimals, of the cells in which every run counts."
            f"{self._incomplete}"
        )

    @property
    def _incomplete(self) -> str:
        """Say how many runs are missing, and how that affects a mean."""
        listed = [each for row in self.rows for each in row.standings if each]
        runs, counted = sum(each.runs for each in listed), sum(each.sample.n for each in listed)
        if counted == runs:
            return ""
        unfinished: Counter[str] = Counter()
        for each in listed:
            unfinished.update(each.unfinished)
        told = [f"{number} {status}" for status, number in unfinished.items()]
        if without := runs - counted - unfinished.total():
            told.append(f"{without} without a finite score")
        return (
            f" {runs - counted} of {runs} runs do not count ({', '.join(told)}): the mean of the "
            "others is likely to be too high where runs failed or diverged."
        )


def score_table(scores: Sequence[CellScores], score: Score, *, normalized: bool) -> ScoreTable:
    """Return the table of a sweep's scores."""
    samples = [(cell, sample(cell.values)) for cell in scores]
    digits = decimals(normalized=normalized)
    best = _best_means(samples, digits)
    standings = {
        (cell.label, cell.spec.environment): Standing(
            cell.spec,
            summary,
            runs=len(cell.seeds),
            unfinished=cell.unfinished,
            is_best=cell.is_complete
            and round(summary.mean, digits) == best.get(cell.spec.environment),
        )
        for cell, summary in samples
    }
    environments = tuple(dict.fromkeys(cell.spec.environment for cell in scores))
    rows = [
        Row(label, tuple(standings.get((label, environment)) for environment in environments))
        for label in labels_of(scores)
    ]
    return ScoreTable(score, normalized, environments, tuple(rows))


def decimals(*, normalized: bool) -> int:
    """How many digits after the point a mean is printed with."""
    return 3 if normalized else 2


def _best_means(samples: Sequence[tuple[CellScores, Sample]], digits: int) -> dict[str, float]:
    """The largest rounded mean of each environment's complete cells."""
    best: dict[str, float] = {}
    for cell, summary in samples:
        if cell.is_complete and math.isfinite(summary.mean):
            environment = cell.spec.environment
            rounded = round(summary.mean, digits)
            best[environment] = max(best.get(environment, rounded), rounded)
    return best
