"""Decisions: levels that step down, looks that wait for all, losers that are dropped."""

from dataclasses import replace

import numpy as np
import pytest

from service.analysis.curves import Floats
from service.analysis.question.confidence_sequence import confidence_sequence
from service.analysis.question.decision import Decisions, Outcome, Refuted, decide, refuted
from service.model.inquiry.question import Method, Question

QUESTION = Question(tuple(range(8)), ("h",), "ddpg", max_seeds=24)
OPEN, BETTER, WORSE, EQUIVALENT, DROPPED, STALLED = Outcome


def evidence(better: list[list[float]], **others: list[list[float]]) -> Refuted:
    """P-values, [comparisons][looks], as log evidence; kinds that are not given have none."""
    none = np.ones_like(better).tolist()
    kinds = (better, others.get("worse", none), others.get("equivalent", none))
    return Refuted(*(-np.log(np.array(each)) for each in kinds))


def take(
    found: Refuted, ended: int | list[int] = 9, entries: tuple[int, ...] | None = None,
    question: Question = QUESTION, n: list[list[int]] | None = None,
) -> Decisions:  # fmt: skip
    comparisons, looks = found.better.shape
    pairs = np.tile(np.arange(1, looks + 1), (comparisons, 1)) if n is None else np.array(n)
    places = entries or tuple(range(comparisons))
    return decide(found, pairs, np.broadcast_to(ended, comparisons), places, question)


def test_one_comparison_is_decided_at_half_the_error_rate() -> None:
    assert take(evidence([[0.0251]])).outcome == [OPEN]
    found = take(evidence([[0.0249]]))
    assert found.outcome == [BETTER]
    assert found.level == pytest.approx([0.025])


def test_each_difference_found_makes_the_next_one_easier() -> None:
    found = take(evidence([[0.012], [0.016], [0.9]]))
    assert found.outcome.tolist() == [OPEN, OPEN, OPEN]  # neither is below .05 / 6
    found = take(evidence([[0.0083], [0.0099], [0.9]]))
    assert found.outcome.tolist() == [BETTER, BETTER, OPEN]
    assert found.level == pytest.approx([0.05 / 6, 0.05 / 5, 0.05 / 4])


def test_equivalence_makes_no_other_decision_easier() -> None:
    found = take(evidence([[0.9], [0.015]], equivalent=[[0.01], [0.9]]))
    assert found.outcome.tolist() == [EQUIVALENT, OPEN]
    assert found.level == pytest.approx([0.05 / 4, 0.05 / 4])


def test_what_is_decided_stays_and_the_others_go_on() -> None:
    found = take(evidence([[0.001, 1.0, 1.0], [1.0, 0.001, 1.0], [1.0, 1.0, 1.0]]))
    assert found.outcome.tolist() == [BETTER, BETTER, OPEN]
    assert found.look.tolist() == [1, 2, 3]


def test_a_look_is_taken_when_all_open_comparisons_have_ended_it() -> None:
    found = evidence([[0.001, 1.0], [1.0, 0.001], [1.0, 0.001]])
    waiting = take(found, [1, 2, 1])
    assert waiting.outcome.tolist() == [BETTER, OPEN, OPEN]
    assert waiting.look.tolist() == [1, 1, 1]
    assert take(found, [1, 2, 2]).outcome.tolist() == [BETTER, BETTER, BETTER]


def test_a_loser_gets_no_more_seeds_where_losers_are_dropped() -> None:
    found = evidence([[1.0, 0.001], [1.0, 1.0], [1.0, 1.0]], worse=[[1.0], [0.001], [1.0]])
    found = Refuted(found.better, np.repeat(found.worse, 2, axis=1), found.equivalent)
    entries = (0, 0, 1)
    kept = take(found, entries=entries)
    assert kept.outcome.tolist() == [BETTER, WORSE, OPEN]
    dropped = take(found, entries=entries, question=replace(QUESTION, drop_losers=True))
    assert dropped.outcome.tolist() == [DROPPED, WORSE, OPEN]
    assert dropped.look.tolist() == [1, 1, 2]


def test_a_batch_without_a_pair_ends_its_comparison_alone() -> None:
    found = evidence([[1.0, 1.0, 0.001], [1.0, 1.0, 0.001], [0.001, 1.0, 1.0]])
    stalled = take(found, n=[[8, 8, 8], [8, 16, 24], [0, 0, 0]])
    assert stalled.outcome.tolist() == [STALLED, BETTER, BETTER]
    assert stalled.look.tolist() == [2, 3, 1]
    assert take(evidence([[1.0]]), n=[[0]]).outcome == [STALLED]


@pytest.mark.parametrize("method", ["bounded", "normal"])
@pytest.mark.parametrize("mean", [-0.2, 0.0, 0.01, 0.2])
def test_decisions_are_what_the_confidence_sequence_shows(method: Method, mean: float) -> None:
    question = replace(QUESTION, method=method, margin=0.05, clip=0.5, max_seeds=400)
    d: Floats = np.clip(np.random.default_rng(0).normal(mean, 0.1, 400), -0.5, 0.5)
    looks = tuple(range(8, 401, 8))
    found = take(Refuted(*(kind[None] for kind in vars(refuted(d, looks, question)).values())), 99)
    shown = confidence_sequence(d, looks, 0.025, method, 0.5)
    last = found.look[0] - 1
    low, high = shown.low, shown.high
    expected = {BETTER: low > 0, WORSE: high < 0, EQUIVALENT: (low > -0.05) & (high < 0.05)}
    assert expected[Outcome(found.outcome[0])][last]
    assert not any(kind[:last].any() for kind in expected.values())


def test_many_sweeps_are_decided_at_once_as_each_by_itself() -> None:
    p = np.random.default_rng(0).uniform(0, 0.05, (20, 3, 4))
    found = Refuted(*(np.maximum.accumulate(-np.log(p), axis=-1) for _ in range(3)))
    n = np.tile(np.arange(1, 5), (3, 1))
    together = decide(found, n, np.full(3, 4), (0, 1, 2), QUESTION)
    for sweep in range(20):
        alone = take(Refuted(*(kind[sweep] for kind in vars(found).values())))
        assert alone.outcome.tolist() == together.outcome[sweep].tolist()
        assert alone.level.tolist() == together.level[sweep].tolist()
