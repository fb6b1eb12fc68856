"""The verdict in words."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from service.analysis.question.confidence_sequence import ConfidenceSequence
from service.analysis.question.decision import Outcome
from service.analysis.question.forecast import Forecast
from service.analysis.question.pairs import Counts, Pairs
from service.analysis.question.sentences import paper_sentence, sentence
from service.analysis.question.verdict import Answer, Verdict
from service.model.inquiry.question import Question

QUESTION = Question(tuple(range(8)), ("h",), "ddpg")


def answer(outcome: Outcome, low: float, high: float, **fields: Any) -> Answer:
    """An answer after 24 seeds."""
    middle = (low + high) / 2
    sequence = ConfidenceSequence((24,), np.array([middle]), np.array([low]), np.array([high]))
    pairs = Pairs("Pendulum", "h", 0, np.zeros(24), (Counts(24),))
    return replace(Answer(pairs, outcome, 24, 0.025, sequence, None), **fields)


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (answer(Outcome.BETTER, 0.05, 0.11), "better by 0.05 to 0.11; 24 seeds"),
        (answer(Outcome.WORSE, -0.11, -0.05), "worse by 0.05 to 0.11; 24 seeds"),
        (answer(Outcome.BETTER, 0.0003, 0.11), "better by 0.0003 to 0.11; 24 seeds"),
        (answer(Outcome.EQUIVALENT, -0.01, 0.01, seeds=1), "equivalent within 0.02; 1 seed"),
        (
            answer(Outcome.OPEN, -0.03, 0.11, forecast=Forecast(40, 0.8)),
            "not decided (-0.03 to 0.11); 24 seeds so far; about 40 more would decide",
        ),
        (
            answer(Outcome.OPEN, -0.03, 0.11, forecast=Forecast(None, 0.0), seeds=128),
            "not decided (-0.03 to 0.11); 128 seeds; more than 512 more would be needed",
        ),
        (answer(Outcome.OPEN, -0.03, 0.11), "not decided (-0.03 to 0.11); 24 seeds so far"),
        (
            answer(Outcome.DROPPED, -0.03, 0.11),
            "dropped after 24 seeds: worse in another task (-0.03 to 0.11)",
        ),
        (
            answer(Outcome.STALLED, -0.03, 0.11),
            "stopped after 24 seeds: no pair of the last batch can be compared, because runs "
            "failed or were cancelled; retry them",
        ),
    ],
)
def test_one_sentence_a_comparison(found: Answer, said: str) -> None:
    assert sentence(found, QUESTION) == said


def test_seconds_also_stop_at_runs_of_different_processors() -> None:
    stalled = answer(Outcome.STALLED, -0.03, 0.11)
    assert sentence(stalled, replace(QUESTION, score="seconds to 0.9")).endswith(
        "because runs failed, were cancelled or had different processors; retry them on equal ones"
    )


def test_a_sentence_for_a_paper_has_method_numbers_and_correction() -> None:
    answers = (answer(Outcome.BETTER, 0.05, 0.11), answer(Outcome.OPEN, -0.03, 0.11))
    text = paper_sentence(Verdict(replace(QUESTION, clip=0.25), answers, is_settled=True))
    for part in (
        "the area under the curve", "each counted up to 0.25", "Waudby-Smith and Ramdas",
        "after 8 seeds and after every 8 more, to at most 128", "over 2 comparisons", "by 0.05.",
        "Better than ddpg: h in Pendulum (+0.080, 95.0% CI 0.05 to 0.11, n = 24).",
        "Not decided: h in Pendulum (+0.040, 95.0% CI -0.03 to 0.11, n = 24).",
    ):  # fmt: skip
        assert part in text
    assert "Worse" not in text


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"method": "normal"}, "sequential t-tests"),
        ({"score": "final"}, "in the last tenth of training"),
        ({"score": "seconds to 0.9"}, "until the normalised return reaches 0.9"),
    ],
)
def test_the_paper_hears_of_what_was_assumed(fields: dict[str, Any], said: str) -> None:
    question = replace(QUESTION, **fields)
    assert said in paper_sentence(Verdict(question, (answer(Outcome.OPEN, 0, 0),), False))
