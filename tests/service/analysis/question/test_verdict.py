"""The verdict: what is known, what is asked for next, and that nothing else matters."""

from dataclasses import replace

import numpy as np
import pytest

from service.analysis.question.decision import Outcome
from service.analysis.question.forecast import fewest_to_equivalence, forecast
from service.analysis.question.pairs import Counts, Pairs
from service.analysis.question.verdict import verdict, wanted
from service.model.inquiry.question import Question

QUESTION = Question(tuple(range(8)), ("h",), "ddpg", clip=0.25, max_seeds=64)
MEANS = {"Acrobot": 0.2, "CartPole": 0.05, "Pendulum": 0.0}


def pairs(environment: str, looks: int, mean: float | None = None) -> Pairs:
    """Those of so many looks; the same ones whenever they are asked for."""
    draws = np.random.default_rng(len(environment))
    mean = MEANS[environment] if mean is None else mean
    d = np.clip(draws.normal(mean, 0.05, 1000), -0.25, 0.25)
    counts = tuple(Counts(len(QUESTION.seeds(k + 1))) for k in range(looks))
    return Pairs(environment, "h", 0, d[: 8 * looks], counts)


def test_every_cell_of_an_open_comparison_gets_the_next_batch() -> None:
    found = [pairs("Acrobot", 2), pairs("CartPole", 2)]
    assert [answer.outcome for answer in verdict(found, QUESTION).answers] == [
        Outcome.BETTER, Outcome.OPEN,
    ]  # fmt: skip
    assert wanted(found, QUESTION) == {
        ("CartPole", "h"): tuple(range(24)), ("CartPole", "ddpg"): tuple(range(24)),
    }  # fmt: skip


def test_a_sweep_that_is_run_batch_by_batch_comes_to_its_end() -> None:
    """Looks of open comparisons only; the outcome is that of the whole history at once."""
    question = replace(QUESTION, margin=0.05)
    looks = dict.fromkeys(MEANS, 0)
    while asked := wanted([pairs(task, n) for task, n in looks.items()], question):
        for task, entry in asked:
            looks[task] += entry == "h"
    found = verdict([pairs(task, n) for task, n in looks.items()], question)
    assert found.is_settled
    assert {a.pairs.environment: (a.outcome.name, a.seeds) for a in found.answers} == {
        "Acrobot": ("BETTER", 16), "CartPole": ("BETTER", 48), "Pendulum": ("EQUIVALENT", 40),
    }  # fmt: skip
    all_at_once = verdict([pairs(task, question.looks) for task in MEANS], question)
    assert repr(all_at_once) == repr(found)


def test_it_waits_for_the_first_look() -> None:
    found = [pairs("CartPole", 0)]
    assert wanted(found, QUESTION) == {
        ("CartPole", "h"): tuple(range(8)), ("CartPole", "ddpg"): tuple(range(8)),
    }  # fmt: skip
    [answer] = verdict(found, QUESTION).answers
    assert (answer.outcome, answer.seeds, answer.forecast) == (Outcome.OPEN, 0, None)
    assert len(answer.sequence.low) == 0


def test_the_budget_ends_what_is_not_decided() -> None:
    question = replace(QUESTION, max_seeds=16)
    found = verdict([pairs("Pendulum", 2)], question)
    assert found.is_settled
    [answer] = found.answers
    assert (answer.outcome, answer.seeds) == (Outcome.OPEN, 16)
    assert answer.forecast is not None
    assert answer.forecast.power == 0.0  # no seed is left
    assert answer.forecast.more is not None


def test_a_forecast_counts_the_seeds_that_would_decide() -> None:
    near, far = (forecast(pairs("CartPole", 2, mean), 0.025, QUESTION) for mean in (0.1, 0.03))
    assert near is not None
    assert far is not None
    assert near.more is not None
    assert far.more is not None
    assert 0 < near.more < far.more
    assert 0 <= far.power <= near.power <= 1


def test_a_forecast_says_nothing_of_three_pairs_nor_of_what_is_too_far() -> None:
    few = replace(pairs("CartPole", 1), differences=np.array([0.1, 0.2, 0.0]), looks=(Counts(3),))
    assert forecast(few, 0.025, QUESTION) is None
    unclear = replace(few, differences=np.array([0.25, -0.25, 0.25, -0.19]), looks=(Counts(4),))
    hopeless = replace(QUESTION, margin=0.0001)
    found = forecast(unclear, 1e-9, hopeless)
    assert found is not None
    assert found.more is None


@pytest.mark.parametrize(("clip", "fewest"), [(1.0, 237), (0.25, 58)])
def test_equivalence_needs_pairs_however_alike_they_are(clip: float, fewest: int) -> None:
    question = replace(QUESTION, clip=clip)
    assert fewest_to_equivalence(question, 1) == fewest
    assert (fewest_to_equivalence(question, 5) or 0) > fewest
    assert fewest_to_equivalence(replace(question, margin=1e-9), 1) is None


def test_a_question_without_a_comparison_is_settled() -> None:
    assert wanted([], QUESTION) == {}
    assert verdict([], QUESTION).is_settled
