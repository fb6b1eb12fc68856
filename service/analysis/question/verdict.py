"""The verdict: a pure function of a question and of the runs that have ended.

The same runs give the same verdict and the same seeds to ask for, whenever and however often it is
computed: nothing else is remembered.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from service.analysis.question.confidence_sequence import ConfidenceSequence, confidence_sequence
from service.analysis.question.decision import Decisions, Outcome, Refuted, decide, refuted
from service.analysis.question.forecast import Forecast, forecast
from service.analysis.question.pairs import Pairs
from service.model.inquiry.question import Question

Cell = tuple[str, str]
"""A task, and an entry's label."""


@dataclass(frozen=True)
class Answer:
    """What is known about one comparison.

    pairs     that the outcome rests on
    outcome   OPEN, too, where the budget has ended
    seeds     of its pairs, whether they count or not
    level     at which either side of `sequence` may fail
    forecast  of an open comparison; None where it is not open, or has too few pairs
    """

    pairs: Pairs
    outcome: Outcome
    seeds: int
    level: float
    sequence: ConfidenceSequence
    forecast: Forecast | None


@dataclass(frozen=True)
class Verdict:
    """The answers, and whether more seeds will be asked for."""

    question: Question
    answers: tuple[Answer, ...]
    is_settled: bool


def decisions(found: Sequence[Pairs], question: Question) -> Decisions:
    """Return what is decided of the comparisons, at least one."""
    most = max(len(pairs.looks) for pairs in found)
    n = [_padded(pairs.n, most) for pairs in found]
    evidence = [
        refuted(pairs.differences, seen, question) for pairs, seen in zip(found, n, strict=True)
    ]
    stacked = Refuted(
        better=np.array([each.better for each in evidence]),
        worse=np.array([each.worse for each in evidence]),
        equivalent=np.array([each.equivalent for each in evidence]),
    )
    ended = np.array([len(pairs.looks) for pairs in found], np.int64)
    counts = np.array(n, np.int64).reshape(len(found), most)
    return decide(stacked, counts, ended, [pairs.place for pairs in found], question)


def _padded(n: tuple[int, ...], looks: int) -> tuple[int, ...]:
    """Return as many looks for all; those that have not ended are never taken."""
    return n + (n[-1] if n else 0,) * (looks - len(n))


def wanted(found: Sequence[Pairs], question: Question) -> dict[Cell, tuple[int, ...]]:
    """Return the seeds that cells shall have for the next look; none if it is settled."""
    return _wanted(found, decisions(found, question), question) if found else {}


def _wanted(
    found: Sequence[Pairs], decided: Decisions, question: Question
) -> dict[Cell, tuple[int, ...]]:
    asked: dict[Cell, tuple[int, ...]] = {}
    for pairs, outcome, look in zip(found, decided.outcome, decided.look, strict=True):
        if outcome == Outcome.OPEN and look < question.looks:
            seeds = question.seeds(int(look) + 1)
            asked |= {(pairs.environment, who): seeds for who in (pairs.label, question.against)}
    return asked


def verdict(found: Sequence[Pairs], question: Question) -> Verdict:
    """Return all that is known."""
    if not found:
        return Verdict(question, (), is_settled=True)
    decided = decisions(found, question)
    answers = tuple(
        _answer(pairs.until(int(look)), Outcome(outcome), float(level), question)
        for pairs, outcome, look, level in zip(
            found, decided.outcome, decided.look, decided.level, strict=True
        )
    )
    return Verdict(question, answers, is_settled=not _wanted(found, decided, question))


def _answer(pairs: Pairs, outcome: Outcome, level: float, question: Question) -> Answer:
    return Answer(
        pairs=pairs,
        outcome=outcome,
        seeds=len(question.seeds(len(pairs.looks))) if pairs.looks else 0,
        level=level,
        sequence=confidence_sequence(
            pairs.differences, pairs.n, level, question.method, question.clip
        ),
        forecast=forecast(pairs, level, question) if outcome == Outcome.OPEN else None,
    )
