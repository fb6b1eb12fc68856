"""Resampling: the law of the draws, and that the same data give the same numbers."""

import numpy as np
import pytest
from scipy import stats

from service.analysis.statistics.stratified_bootstrap import (
    RESAMPLES,
    draw_counts,
    estimate,
    kept_counts,
)


def test_each_resample_has_as_many_runs() -> None:
    counts = draw_counts(16, 0)
    assert counts.shape == (RESAMPLES, 16)
    assert (counts.sum(axis=1) == 16).all()
    np.testing.assert_allclose(counts.mean(axis=0), 1.0, atol=0.1)


def test_draws_are_the_same_each_time_and_differ_by_task() -> None:
    kept_counts.clear()
    first = draw_counts(5, 0)
    assert np.array_equal(draw_counts(5, 0), first), "kept"
    kept_counts.clear()
    assert np.array_equal(draw_counts(5, 0), first), "drawn again"
    assert not np.array_equal(draw_counts(5, 1), first)


def test_no_more_is_kept_than_was_said() -> None:
    kept_counts.clear()
    of_a_run = RESAMPLES * 2
    runs = int(kept_counts.maxsize) // of_a_run // 3
    for stratum in range(5):
        draw_counts(runs, stratum)
        assert kept_counts.currsize == min(stratum + 1, 3) * runs * of_a_run
    kept_counts.clear()


def test_the_interval_of_a_mean_is_scipys() -> None:
    """Two sets of 2000 resamples agree within their Monte Carlo error."""
    values = np.random.default_rng(3).gamma(2.0, size=24)
    own = estimate(values.mean(), draw_counts(24, 0) @ values / 24, is_defined=True)
    other = stats.bootstrap(
        (values,), np.mean, method="percentile", n_resamples=20_000,
        rng=np.random.default_rng(0),
    ).confidence_interval  # fmt: skip
    width = other.high - other.low
    assert own.low == pytest.approx(other.low, abs=0.05 * width)
    assert own.high == pytest.approx(other.high, abs=0.05 * width)


def test_an_interval_that_is_not_defined() -> None:
    one = estimate(0.5, np.full(RESAMPLES, 0.5), is_defined=False)
    assert one.value == 0.5
    assert np.isnan([one.low, one.high]).all()
