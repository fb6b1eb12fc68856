"""Holm's correction, against numbers worked out by hand."""

import numpy as np
import pytest

from service.analysis.statistics.holm import holm


def test_worked_by_hand() -> None:
    """0.01 x 4, 0.02 x 3, 0.03 x 2 and no less than what came before, 0.5 x 1."""
    corrected = holm([0.5, 0.02, 0.01, 0.03], 4)
    assert corrected == pytest.approx([0.5, 0.06, 0.04, 0.06])


def test_tests_that_have_no_p_yet_count() -> None:
    assert holm([0.01, 0.001], 7) == pytest.approx([0.06, 0.007])


def test_no_p_is_above_one() -> None:
    assert list(holm([0.9, 0.4], 2)) == [0.9, 0.8]
    assert list(holm([0.9, 0.6], 2)) == [1.0, 1.0]


def test_of_nothing() -> None:
    assert holm([], 3).shape == (0,)


def test_a_false_finding_is_as_rare_as_it_says() -> None:
    """In none of seven tests is there anything to be found; in 5 % of the families one is."""
    p = np.random.default_rng(0).random((4000, 7))
    found = np.mean([holm(list(row), 7).min() <= 0.05 for row in p])
    assert found == pytest.approx(0.05, abs=0.01)
