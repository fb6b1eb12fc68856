"""Paired differences: the gain of an entry over another, seed by seed, in one task.

    d = score of ours - score of theirs, each score in [0, 1]: 0 acts at random, 1 is the best
    d = (t' - t) / max(t, t')            for "seconds to X": the share of the time that is saved

    t, t'  processor seconds of training until return_mean first reaches X on the normalised scale;
           infinite where it never does, and d = 0 where neither does

A score outside [0, 1] counts as the nearer of both: a run that is worse than acting at random is as
bad as that. So does a run that diverged, and one with a score that is not finite: they are what the
algorithm does. A run that failed or was cancelled says nothing of its algorithm, and its pair is
left out; for seconds, so is a pair that two kinds of processors trained. Differences beyond -clip
and clip count as those.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

import numpy as np

from service.analysis.comparison import grouped, scale
from service.analysis.curves import Floats
from service.analysis.statistics.score import SCORES, Scored
from service.model.inquiry.question import Question
from service.model.processor import are_comparable
from service.model.request.entry import Entries
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from workers.messages.random_return import RandomReturn

COUNTED = (RunStatus.SUCCEEDED, RunStatus.DIVERGED)
Pair = tuple[RunCurve, RunCurve]


@dataclass(frozen=True)
class Counts:
    """Of the pairs until a look: those that count, those that are left out, runs that diverged.

    unequal  of those left out, how many are for their processors alone
    """

    n: int = 0
    left_out: int = 0
    ours_diverged: int = 0
    theirs_diverged: int = 0
    unequal: int = 0


@dataclass(frozen=True)
class Pairs:
    """The pairs of one comparison.

    place        of the entry among those that are asked about
    differences  of the pairs that count, in the order of the question's seeds
    looks        of which every run has ended
    """

    environment: str
    label: str
    place: int
    differences: Floats
    looks: tuple[Counts, ...]

    @property
    def n(self) -> tuple[int, ...]:
        """How many pairs count at each look."""
        return tuple(each.n for each in self.looks)

    def until(self, looks: int) -> "Pairs":
        """Return those of the first looks."""
        kept = self.looks[:looks]
        return replace(self, looks=kept, differences=self.differences[: kept[-1].n if kept else 0])


def all_pairs(
    run_curves: Sequence[RunCurve],
    entries: Entries,
    question: Question,
    random_returns: Mapping[tuple[str, int], RandomReturn],
    best_return: Callable[[str], float],
) -> list[Pairs]:
    """Return the pairs of a sweep's comparisons, task by task.

    The curves are of return_mean, over seconds where the question is about these, else timesteps.
    """
    cells = {
        cell: {run.spec.seed: run for run in runs}
        for cell, runs in grouped(
            run_curves, lambda run: (run.spec.environment, entries.label(run))
        ).items()
    }
    found = []
    for environment in dict.fromkeys(environment for environment, _ in entries.cells):
        theirs = cells.get((environment, question.against), {})
        for place, label in enumerate(question.compare):
            if (ours := cells.get((environment, label))) and theirs:
                version = next(iter(ours.values())).environment_version
                zero = random_returns.get((environment, version))
                unit = scale(zero, best_return(environment))
                found.append(_pairs(environment, label, place, (ours, theirs), unit, question))
    return found


def _pairs(
    environment: str,
    label: str,
    place: int,
    runs: tuple[Mapping[int, RunCurve], Mapping[int, RunCurve]],
    unit: tuple[float, float],
    question: Question,
) -> Pairs:
    is_known = bool(np.isfinite(unit).all())
    looks = range(1, question.looks + 1) if is_known else ()
    ended = list(takewhile(lambda look: _have_ended(runs, question, look), looks))
    pairs = [(runs[0][s], runs[1][s]) for s in question.seeds(ended[-1])] if ended else []
    counted = [pair for pair in pairs if _counts(pair, question)]
    differences = [_difference(*pair, unit, question) for pair in counted]
    return Pairs(
        environment=environment,
        label=label,
        place=place,
        differences=np.clip(np.array(differences, np.float64), -question.clip, question.clip),
        looks=tuple(_counted(pairs[: len(question.seeds(look))], question) for look in ended),
    )


def _have_ended(
    runs: tuple[Mapping[int, RunCurve], Mapping[int, RunCurve]], question: Question, look: int
) -> bool:
    return all(
        seed in own and own[seed].status.is_final for own in runs for seed in question.seeds(look)
    )


def _counts(pair: Pair, question: Question) -> bool:
    return _are_told(pair) and not _is_unequal(pair, question)


def _are_told(pair: Pair) -> bool:
    return all(run.status in COUNTED for run in pair)


def _is_unequal(pair: Pair, question: Question) -> bool:
    is_of_seconds = question.threshold is not None
    return is_of_seconds and not are_comparable(*(run.processor for run in pair))


def _counted(pairs: Sequence[Pair], question: Question) -> Counts:
    told = [pair for pair in pairs if _are_told(pair)]
    unequal = sum(_is_unequal(pair, question) for pair in told)
    n = len(told) - unequal
    ours, theirs = (
        sum(pair[side].status is RunStatus.DIVERGED for pair in pairs) for side in (0, 1)
    )
    return Counts(n, len(pairs) - n, ours, theirs, unequal)


def _difference(
    ours: RunCurve, theirs: RunCurve, unit: tuple[float, float], question: Question
) -> float:
    if question.threshold is None:
        [score] = [kind.of for name, kind in SCORES.items() if name == question.score]
        return _score(ours, score, unit) - _score(theirs, score, unit)
    t, other = (_seconds(run, question.threshold, unit) for run in (ours, theirs))
    if t == other:
        return 0.0
    if np.isinf([t, other]).any():
        return 1.0 if np.isinf(other) else -1.0
    return (other - t) / max(t, other)


def _score(run: RunCurve, score: Scored, unit: tuple[float, float]) -> float:
    """Return the normalised score in [0, 1]."""
    if run.status is not RunStatus.SUCCEEDED or not len(run.values):
        return 0.0
    start, length = unit
    found = (score(run.x, run.values, run.spec.timesteps) - start) / length
    return float(np.clip(found, 0.0, 1.0)) if np.isfinite(found) else 0.0


def _seconds(run: RunCurve, threshold: float, unit: tuple[float, float]) -> float:
    """Return the seconds until the normalised values reach a threshold; infinite: never."""
    start, length = unit
    with np.errstate(invalid="ignore"):
        reached = np.flatnonzero((run.values - start) / length >= threshold)
    is_counted = run.status is RunStatus.SUCCEEDED and len(reached)
    return float(run.x[reached[0]]) if is_counted else np.inf
