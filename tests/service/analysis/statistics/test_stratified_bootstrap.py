"""Resampling: the law of the draws, and that the same data give the same numbers."""

import numpy as np
import pytest
from scipy import stats

from service.analysis.statistics.stratified_bootstrap import (
    RESAMPLES,
    Draws,
    draw_counts,
    estimate,
)


def test_each_resample_has_as_many_runs() -> None:
    counts = draw_counts(16, 0)
    assert counts.shape == (RESAMPLES, 16)
    assert (counts.sum(axis=1) == 16).all()
    np.testing.assert_allclose(counts.mean(axis=0), 1.0, atol=0.1)


def test_draws_are_the_same_each_time_and_differ_by_task() -> None:
    first = Draws(most_bytes=0).counts(5, 0)
    assert np.array_equal(Draws(most_bytes=2**20).counts(5, 0), first)
    assert np.array_equal(draw_counts(5, 0), first.astype(np.float64))
    assert not np.array_equal(draw_counts(5, 1), first)


def test_no_more_is_kept_than_was_said_and_the_oldest_go_first() -> None:
    each = RESAMPLES * 5 * 2
    draws = Draws(most_bytes=2 * each)
    kept = [draws.counts(5, stratum) for stratum in range(2)]
    assert draws.counts(5, 0) is kept[0]
    draws.counts(5, 2)
    assert draws.bytes == 2 * each
    assert draws.counts(5, 0) is kept[0]
    assert draws.counts(5, 1) is not kept[1], "it was used last before the others"
    draws.counts(1000, 0)
    assert draws.bytes <= 2 * each


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
