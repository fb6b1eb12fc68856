"""Questions, as requests ask them."""

import pytest

from service.model.inquiry.question import Question

ASKED = {"compare": ["hybrid-ddpg"], "with": "ddpg", "until": "decided", "margin": 0.05}


def test_a_sweep_may_ask_nothing() -> None:
    assert Question.of({"seeds": 3}) is None


def test_a_question_is_read_off_its_request() -> None:
    question = Question.of({"seeds": 3, "question": ASKED})
    assert question == Question((0, 1, 2), ("hybrid-ddpg",), "ddpg", margin=0.05)


def test_further_seeds_follow_the_first_ones() -> None:
    question = Question((200, 7), ("h",), "ddpg", batch=3, max_seeds=6)
    assert question.looks == 3
    assert [question.seeds(look) for look in (1, 2, 3)] == [
        (200, 7),
        (200, 7, 201, 202, 203),
        (200, 7, 201, 202, 203, 204),
    ]


def test_seeds_that_chose_settings_are_passed_over() -> None:
    question = Question(tuple(range(98)), ("h",), "ddpg", batch=4, max_seeds=104)
    assert question.seeds(3)[98:] == (98, 99, 116, 117, 118, 119)
    at_searches = Question((999_999_998,), ("h",), "ddpg", batch=2, max_seeds=3)
    assert at_searches.seeds(2) == (999_999_998, 999_999_999, 1_000_010_000)


def test_more_first_seeds_than_the_budget_are_one_look() -> None:
    question = Question((0, 1, 2), ("h",), "ddpg", max_seeds=2)
    assert question.looks == 1
    assert question.seeds(1) == (0, 1, 2)


@pytest.mark.parametrize(
    ("score", "threshold"),
    [("area", None), ("seconds to 0.9", 0.9), ("seconds to 1", 1.0), ("seconds to 0.25", 0.25)],
)
def test_seconds_are_to_a_threshold(score: str, threshold: float | None) -> None:
    assert Question((0,), ("h",), "ddpg", score=score).threshold == threshold
