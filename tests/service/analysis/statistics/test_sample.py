"""A sample's mean and interval, against worked numbers and scipy."""

import math

import numpy as np
import pytest
from scipy import stats

from service.analysis.statistics.sample import sample


def test_worked_by_hand() -> None:
    """1, 2, 6: mean 3, s = sqrt(7), t(2) = 4.302653."""
    one = sample(np.array([1.0, 2.0, 6.0]))
    assert (one.n, one.mean) == (3, 3.0)
    assert one.std == pytest.approx(math.sqrt(7), rel=1e-15)
    assert one.high - one.mean == pytest.approx(4.302652730 * math.sqrt(7 / 3), rel=1e-9)
    assert one.mean - one.low == pytest.approx(one.high - one.mean, rel=1e-15)


def test_the_interval_is_scipys() -> None:
    values = np.random.default_rng(1).standard_normal(16)
    expected = stats.ttest_1samp(values, 0).confidence_interval(0.95)
    one = sample(values)
    assert (one.low, one.high) == pytest.approx((expected.low, expected.high), rel=1e-12)


def test_what_is_not_finite_is_not_counted() -> None:
    one = sample(np.array([math.nan, 2.0, math.inf]))
    assert (one.n, one.mean) == (1, 2.0)
    assert all(map(math.isnan, (one.std, one.low, one.high)))


def test_of_nothing() -> None:
    one = sample(np.array([math.nan]))
    assert one.n == 0
    assert all(map(math.isnan, (one.mean, one.std, one.low, one.high)))
