"""The aggregate: exact, from all seeds, with n; against the plain formulas."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from service.analysis.curves import Band, Series, aggregate, thin

NAN = math.nan


def series(x: list[float], y: list[float]) -> Series:
    return Series(np.array(x, np.float64), np.array(y, np.float64))


def test_mean_and_standard_deviation() -> None:
    curve = aggregate(
        [series([1, 2], [1, 10]), series([1, 2], [2, 20]), series([1, 2], [6, 60])], "std", 300
    )
    assert curve.x.tolist() == [1, 2]
    assert curve.mean.tolist() == [3, 30]
    deviation = [math.sqrt(7), math.sqrt(700)]
    np.testing.assert_allclose(curve.high - curve.mean, deviation, rtol=1e-15)
    np.testing.assert_allclose(curve.mean - curve.low, deviation, rtol=1e-15)
    assert curve.n.tolist() == [3, 3]
    assert not curve.is_interpolated


def test_a_seed_that_lags_is_counted_where_it_is() -> None:
    curve = aggregate([series([1, 2, 3], [1, 1, 1]), series([1], [3])], "std", 300)
    assert curve.n.tolist() == [2, 1, 1]
    assert curve.mean.tolist() == [2, 1, 1]
    assert np.isnan(curve.low[1:]).all()
    assert not curve.is_interpolated


def test_what_is_not_finite_is_left_out_and_not_counted() -> None:
    curve = aggregate(
        [series([1, 2, 3], [NAN, math.inf, 5]), series([1, 2, 3], [2, 4, -math.inf])], "std", 300
    )
    assert curve.n.tolist() == [1, 1, 1]
    assert curve.mean.tolist() == [2, 4, 5]


def test_nothing_finite_has_no_mean() -> None:
    curve = aggregate([series([1], [NAN])], "iqr", 300)
    assert curve.n.tolist() == [0]
    assert np.isnan([curve.mean[0], curve.low[0], curve.high[0]]).all()


def test_nothing_measured_has_no_points() -> None:
    for band in ("std", "ci95", "iqr"):
        for seeds in ([], [series([], [])], [series([], []), series([], [])]):
            curve = aggregate(seeds, band, 300)
            assert len(curve.x) == len(curve.mean) == len(curve.n) == 0


def test_confidence_interval_is_students() -> None:
    values = [1.0, 2.0, 4.0, 8.0]
    curve = aggregate([series([1], [value]) for value in values], "ci95", 300)
    low, high = stats.t.interval(0.95, 3, np.mean(values), stats.sem(values))
    assert curve.low[0] == pytest.approx(low, rel=1e-12)
    assert curve.high[0] == pytest.approx(high, rel=1e-12)


def test_different_steps_are_interpolated_inside_a_seeds_own_range_alone() -> None:
    curve = aggregate([series([0, 2, 4], [0, 2, 4]), series([1, 3], [10, 30])], "std", 300)
    assert curve.is_interpolated
    assert curve.x.tolist() == [0, 1, 2, 3, 4]
    assert curve.n.tolist() == [1, 2, 2, 2, 1]
    np.testing.assert_allclose(curve.mean, [0, 5.5, 11, 16.5, 4])


def test_interpolation_does_not_bridge_what_is_not_finite() -> None:
    curve = aggregate([series([0, 2, 4], [0, NAN, 4]), series([1, 2, 3], [1, 2, 3])], "std", 300)
    assert curve.n.tolist() == [1, 1, 1, 1, 1]
    assert curve.mean.tolist() == [0, 1, 2, 3, 4]


def test_the_last_value_at_an_x_counts() -> None:
    """Along Jacobian evaluations, an algorithm that needs none stands still."""
    curve = aggregate([series([0, 0, 0], [1, 2, 3])], "std", 300)
    assert curve.x.tolist() == [0]
    assert curve.mean.tolist() == [3]


@pytest.mark.parametrize(
    ("count", "max_points", "kept"),
    [
        (10, 10, list(range(10))),
        (10, 4, [0, 3, 6, 9]),
        (11, 4, [0, 4, 8, 10]),
        (5, 2, [0, 4]),
        (1, 2, [0]),
        (0, 2, []),
    ],
)
def test_thin(count: int, max_points: int, kept: list[int]) -> None:
    assert thin(np.arange(count, dtype=np.float64), max_points).tolist() == kept


@given(st.integers(0, 2000), st.integers(2, 400))
def test_thinning_keeps_the_ends_and_the_limit(count: int, max_points: int) -> None:
    x = np.arange(count, dtype=np.float64)
    kept = thin(x, max_points)
    assert len(kept) == min(count, len(kept))
    assert len(kept) <= max_points
    assert set(kept.tolist()) <= set(x.tolist())
    if count > 1:
        assert (kept[0], kept[-1]) == (0, count - 1)


def test_a_thinned_curve_has_the_values_of_the_whole_one() -> None:
    rng = np.random.default_rng(0)
    x = [800.0 * k for k in range(1, 251)]
    seeds = [series(x, rng.standard_normal(250).tolist()) for _ in range(16)]
    whole, thinned = aggregate(seeds, "std", 300), aggregate(seeds, "std", 40)
    at = np.searchsorted(whole.x, thinned.x)
    assert np.array_equal(thinned.mean, whole.mean[at])
    assert np.array_equal(thinned.low, whole.low[at])


bands = st.sampled_from(["std", "ci95", "iqr"])
values = st.floats(allow_nan=True, allow_infinity=True)


@given(st.lists(st.lists(values, min_size=4, max_size=4), min_size=1, max_size=6), bands)
def test_any_numbers(table: list[list[float]], band: Band) -> None:
    """Against numpy's own functions, a column at a time; the order of the seeds does not matter."""
    x = [1.0, 2.0, 3.0, 4.0]
    curve = aggregate([series(x, row) for row in table], band, 300)
    for j, column in enumerate(np.array(table).T):
        finite = column[np.isfinite(column)]
        assert curve.n[j] == len(finite)
        if not len(finite) or np.abs(finite).max() > 1e150:
            continue
        assert curve.mean[j] == pytest.approx(finite.mean(), rel=1e-12, abs=1e-300)
        if band == "iqr":
            expected = np.quantile(finite, [0.25, 0.75])
            np.testing.assert_allclose([curve.low[j], curve.high[j]], expected, rtol=1e-9)
        elif band == "std" and len(finite) > 1:
            half = (curve.high[j] - curve.low[j]) / 2
            scale = np.abs(finite).max()
            assert half == pytest.approx(finite.std(ddof=1), rel=1e-9, abs=1e-12 * scale)
