"""What questions promise, on 2,000 simulated sweeps of seven tasks with our own scores.

`python -m tests.service.analysis.question.simulated_sweeps` prints the tables of docs/questions.md.
"""

from pathlib import Path

import pytest

from tests.service.analysis.question.simulated_sweeps import (
    FIXED,
    WAYS,
    as_measured,
    decided,
    error_rows,
    missed,
    naive,
    no_difference,
    question_of,
    saving_rows,
    savings,
    wrong,
)

MOST = 0.05
DOCS = Path(__file__).parents[4] / "docs"


def test_looks_at_no_difference_decide_wrongly_in_five_percent_at_most() -> None:
    question = question_of()
    drawn = no_difference("ddpg", "area", question)
    assert wrong(decided(drawn, question), drawn, question).mean() <= MOST
    assert missed(drawn, question).mean(axis=0).max() <= MOST
    assert naive(drawn, question).mean() > 0.5  # Student's interval at every look


def test_real_differences_are_not_decided_the_wrong_way() -> None:
    """Final scores of the hybrid collapse in some of its runs."""
    question = question_of()
    drawn = as_measured("hybrid-ddpg", "final", question)
    assert wrong(decided(drawn, question), drawn, question).mean() <= MOST
    assert missed(drawn, question).mean(axis=0).max() <= MOST


def test_a_large_difference_takes_fewer_seeds_than_a_fixed_number() -> None:
    question = question_of(clip=0.25, max_seeds=64)
    assert (savings("CartPole", "hybrid-ddpg", question) or FIXED) < FIXED


def test_tables_of_the_documentation_are_those_of_the_published_scores() -> None:
    lines = (DOCS / "questions.md").read_text(encoding="utf-8").splitlines()
    assert [row for row in (*error_rows(), *saving_rows()) if row not in lines] == []


@pytest.mark.slow
@pytest.mark.parametrize("score", ["area", "final"])
@pytest.mark.parametrize("algorithm", ["ddpg", "hybrid-ddpg", "hybrid-ddpg-cosine"])
@pytest.mark.parametrize(("method", "clip"), WAYS)
def test_every_way_keeps_its_promise(score: str, algorithm: str, method: str, clip: float) -> None:
    """That of "normal" is the rate of false decisions under no difference alone."""
    question = question_of(method, clip)  # type: ignore[arg-type]
    same = no_difference(algorithm, score, question)
    assert wrong(decided(same, question), same, question).mean() <= MOST
    assert naive(same, question).mean() > 0.5
    if method == "bounded":
        real = as_measured(algorithm, score, question)
        assert wrong(decided(real, question), real, question).mean() <= MOST
        for drawn in (same, real):
            assert missed(drawn, question).mean(axis=0).max() <= MOST
