"""Rows without a solution are found, and replaced."""

from collections.abc import Callable

import numpy as np
import pytest

from algorithms.unsolved_step import call_with_substitutes, unsolved_rows
from physics.environment import DomainError, FloatArray, NotFiniteError, UnsolvedStepError


def total(states: FloatArray, actions: FloatArray) -> FloatArray:
    """Has no solution above 1."""
    if (states > 1.0).any():
        raise UnsolvedStepError(f"{states.max()} is above 1")
    result: FloatArray = states[:, 0] + actions[:, 0]
    return result


class Fragile:
    """Refuses what is above 1, for one reason or another."""

    def __init__(self, reason: Callable[[str], Exception]) -> None:
        self.reason = reason

    def __call__(self, states: FloatArray, actions: FloatArray) -> FloatArray:
        if (states > 1.0).any():
            raise self.reason("above 1")
        return total(states, actions)


@pytest.mark.parametrize(
    "reason",
    [
        UnsolvedStepError,
        lambda text: DomainError(text, [0]),
        lambda text: NotFiniteError(text, [0]),
    ],
)
def test_rows_are_replaced_whatever_they_are_refused_for(
    reason: Callable[[str], Exception],
) -> None:
    states, good = np.array([[0.0], [5.0]]), np.zeros((2, 1))
    result, is_refused = call_with_substitutes(
        Fragile(reason), states, np.ones((2, 1)), lambda: (good, good)
    )
    assert result.tolist() == [1.0, 0.0]
    assert is_refused.tolist() == [False, True]


@pytest.mark.parametrize("bad", [[], [0], [6], [2, 3], [0, 1, 2, 3, 4, 5, 6]])
def test_every_bad_row_is_found(bad: list[int]) -> None:
    states, actions = np.zeros((7, 1)), np.zeros((7, 1))
    states[bad] = 2.0
    assert np.flatnonzero(unsolved_rows(total, states, actions)).tolist() == bad


def test_bad_rows_are_replaced_and_the_others_stay() -> None:
    states = np.array([[0.0], [5.0], [0.5]])
    result, is_unsolved = call_with_substitutes(
        total, states, np.ones((3, 1)), lambda: (np.full((3, 1), 0.25), np.full((3, 1), 7.0))
    )
    assert result.tolist() == [1.0, 7.25, 1.5]
    assert is_unsolved.tolist() == [False, True, False]


def test_what_is_solved_asks_for_no_substitutes() -> None:
    def refuse() -> tuple[FloatArray, FloatArray]:
        raise AssertionError("nobody needs them")

    result, is_unsolved = call_with_substitutes(total, np.zeros((2, 1)), np.ones((2, 1)), refuse)
    assert result.tolist() == [1.0, 1.0]
    assert not is_unsolved.any()


def test_bad_substitutes_are_an_error() -> None:
    bad = np.full((1, 1), 2.0)
    with pytest.raises(UnsolvedStepError, match=r"2\.0 is above 1"):
        call_with_substitutes(total, bad, bad, lambda: (bad, bad))
