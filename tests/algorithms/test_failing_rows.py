"""Rows that raise are found, and others stand in for them."""

import numpy as np
import pytest

from algorithms.failing_rows import call_rows
from physics.environment import FloatArray


def total(states: FloatArray, actions: FloatArray) -> FloatArray:
    """Has no answer above 1."""
    if (states > 1.0).any():
        raise ArithmeticError(f"{states.max()} is above 1")
    result: FloatArray = states[:, 0] + actions[:, 0]
    return result


@pytest.mark.parametrize("bad", [[], [0], [6], [2, 3], [1, 4, 5, 6], [0, 1, 2, 3, 4, 5]])
def test_every_bad_row_is_found_with_its_own_error_and_a_good_one_stands_in(bad: list[int]) -> None:
    states, actions = np.zeros((7, 1)), np.arange(7.0)[:, None]
    states[bad, 0] = 2.0 + np.arange(len(bad))
    result, failures = call_rows(total, states, actions)
    assert sorted(failures) == bad
    assert [str(failures[row]) for row in bad] == [f"{states[row, 0]} is above 1" for row in bad]
    good = [row for row in range(7) if row not in bad]
    assert result is not None
    assert result[good].tolist() == good
    assert result[bad].tolist() == [good[0]] * len(bad)


def test_where_all_are_bad_there_is_no_result() -> None:
    result, failures = call_rows(total, np.full((3, 1), 2.0), np.zeros((3, 1)))
    assert result is None
    assert list(failures) == [0, 1, 2]


def test_named_substitutes_stand_in() -> None:
    states, actions = np.array([[0.0], [5.0], [0.5]]), np.array([[7.0], [8.0], [9.0]])
    result, failures = call_rows(total, states, actions, substitutes=np.array([0, 2, 0]))
    assert result is not None
    assert result.tolist() == [7.0, 9.5, 9.5]
    assert list(failures) == [1]


def test_bad_substitutes_are_an_error() -> None:
    bad = np.full((1, 1), 2.0)
    with pytest.raises(ArithmeticError, match=r"2\.0 is above 1"):
        call_rows(total, bad, bad, substitutes=np.array([0]))


def test_a_batch_that_fails_as_a_batch_alone_is_an_error() -> None:
    def lonely(states: FloatArray) -> FloatArray:
        if len(states) > 1:
            raise MemoryError("too many rows")
        return states

    with pytest.raises(MemoryError, match="too many rows"):
        call_rows(lonely, np.zeros((2, 1)))
