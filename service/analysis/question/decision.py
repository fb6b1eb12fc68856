"""Decisions of all comparisons of a question, look by look, with one error rate for all of them.

A comparison of mean mu is

    better       when "mu <= 0" is refuted                  worse  when "mu >= 0" is refuted
    equivalent   when "mu <= -margin" and "mu >= margin" are refuted

each when its p-value, which holds at any time, is at most `level`. With K comparisons, of which j
are known to differ (better or worse) so far,

    level = (1 - confidence) / (2 K - j)

This is Holm's step-down procedure over the 2 K one-sided hypotheses. It keeps the probability of
any wrong decision, of whatever kind and at any time, below 1 - confidence. A decision about a mean
above 0 is wrong only if its upper bound fails, one about a mean below 0 only if its lower bound
does, and one about a mean of 0 if either does. Let M be how many bounds these are. Until the first
wrong decision j counts true differences only, so that 2 K - j >= M. At level (1 - confidence) / M
a bound ever fails with at most that probability, and M of them with at most 1 - confidence.
Nothing is assumed of how comparisons depend on each other: they may share a baseline and seeds.

All comparisons that are open are looked at together: the look's result does not depend on which of
them ended first.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from service.analysis.curves import Floats
from service.analysis.question.evidence import log_evidence
from service.model.inquiry.question import Question

Codes = NDArray[np.int8]
Looks = NDArray[np.int64]


class Outcome(IntEnum):
    """The state of a comparison."""

    OPEN = 0
    BETTER = 1
    WORSE = 2
    EQUIVALENT = 3
    DROPPED = 4
    """Its entry was worse in another task, and losers are dropped."""
    STALLED = 5
    """No pair of its last batch can be compared: their runs failed or were cancelled."""


@dataclass(frozen=True)
class Refuted:
    """Log evidence for each kind of decision [..., comparisons, looks], the largest so far."""

    better: Floats
    worse: Floats
    equivalent: Floats


@dataclass(frozen=True)
class Decisions:
    """The outcome of each comparison.

    outcome  [..., comparisons] of `Outcome`
    look     [..., comparisons] number of looks until it was decided, or so far
    level    [..., comparisons] at which it was decided, or would be at the next look
    """

    outcome: Codes
    look: Looks
    level: Floats


def refuted(differences: Floats, n: Sequence[int], question: Question) -> Refuted:
    """Return the evidence of differences [..., k] at looks after the first n of them."""
    margin = question.margin

    def largest(d: Floats, value: float) -> Floats:
        evidence = log_evidence(d, value, n, question.method, question.clip)
        so_far: Floats = np.maximum.accumulate(evidence, axis=-1)
        return so_far

    above, below = largest(differences, -margin), largest(-differences, -margin)
    return Refuted(largest(differences, 0.0), largest(-differences, 0.0), np.minimum(above, below))


def decide(
    evidence: Refuted,
    n: Looks,
    ended: Looks,
    entries: Sequence[int],
    question: Question,
) -> Decisions:
    """Return what is decided.

    Args:
        evidence: of each comparison at each look.
        n: the pairs that count at each look [comparisons, looks].
        ended: the looks for which each comparison has all its runs [comparisons]. A look is taken
            when every open comparison has them.
        entries: of which entry each comparison is.
        question: says the error rate, and whether losers are dropped.
    """
    outcome = np.zeros(evidence.better.shape[:-1], np.int8)
    look = np.zeros(outcome.shape, np.int64)
    level = np.broadcast_to(_level(outcome, question), outcome.shape).copy()
    for k in range(evidence.better.shape[-1]):
        open_ = outcome == Outcome.OPEN
        if (open_ & (ended <= k)).any():
            break
        look += open_
        _take(evidence, k, outcome, level, question)
        is_stalled = n[:, k] == (n[:, k - 1] if k else 0)
        outcome[(outcome == Outcome.OPEN) & is_stalled] = Outcome.STALLED
        if question.drop_losers:
            _drop(outcome, np.asarray(entries))
    return Decisions(outcome, look, level)


def _take(evidence: Refuted, k: int, outcome: Codes, level: Floats, question: Question) -> None:
    """Take look k, changing outcome and level in place: step down until nothing more is decided."""
    kinds = {
        Outcome.BETTER: evidence.better[..., k],
        Outcome.WORSE: evidence.worse[..., k],
        Outcome.EQUIVALENT: evidence.equivalent[..., k],
    }
    before = None
    while before is None or (before != outcome).any():
        before = outcome.copy()
        bar = np.broadcast_to(_level(outcome, question), outcome.shape)
        for kind, found in kinds.items():
            outcome[(outcome == Outcome.OPEN) & (found >= -np.log(bar))] = kind
        level[:] = np.where(before == Outcome.OPEN, bar, level)


def _level(outcome: Codes, question: Question) -> Floats:
    """Return the level [..., 1] at which open comparisons are decided."""
    differ = ((outcome == Outcome.BETTER) | (outcome == Outcome.WORSE)).sum(-1, keepdims=True)
    level: Floats = question.error_rate / (2 * outcome.shape[-1] - differ)
    return level


def _drop(outcome: Codes, entries: NDArray[np.int64]) -> None:
    """Leave the open comparisons of entries that are worse somewhere."""
    for entry in np.unique(entries):
        own = entries == entry
        lost = (outcome[..., own] == Outcome.WORSE).any(-1, keepdims=True)
        outcome[(outcome == Outcome.OPEN) & own & lost] = Outcome.DROPPED
