"""Statistics of scores: against values worked by hand, scipy, and direct resampling."""

import math

import numpy as np
import pytest
from scipy import stats

from service.analysis.curves import Floats
from service.analysis.statistics.score_statistics import (
    interquartile_mean,
    paired_probability_of_improvement,
    performance_profile,
    probability_of_improvement,
)
from service.analysis.statistics.stratified_bootstrap import draw_counts


def arrays(*tasks: list[float]) -> list[Floats]:
    return [np.array(task, np.float64) for task in tasks]


def seeds(*counts: int) -> list[tuple[int, ...]]:
    return [tuple(range(count)) for count in counts]


def test_interquartile_mean_by_hand() -> None:
    """Of 0 ... 8 and 100, ten in two tasks, two at either end go: 2 ... 7 are left."""
    scores = arrays([100, 0, 1, 2, 3], [4, 5, 6, 7, 8])
    assert interquartile_mean(scores).value == 4.5
    assert interquartile_mean(arrays([3.0, 1.0, 2.0])).value == 2.0


def test_every_resample_is_trimmed_as_if_alone() -> None:
    """The counts, written out as the runs they stand for, through scipy's own trimmed mean."""
    rng = np.random.default_rng(5)
    scores = [rng.standard_normal(7), rng.standard_normal(10)]
    counts = [draw_counts(7, 0), draw_counts(10, 1)]
    direct = [
        stats.trim_mean(
            np.concatenate(
                [np.repeat(s, c[k].astype(int)) for s, c in zip(scores, counts, strict=True)]
            ),
            0.25,
        )
        for k in range(len(counts[0]))
    ]
    low, high = np.quantile(direct, [0.025, 0.975])
    found = interquartile_mean(scores)
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-12)


def test_intervals_cover_the_truth() -> None:
    """Of 300 normal samples of 2 tasks by 16 runs, 95 % or nearly so hold their true IQM, 0."""
    rng = np.random.default_rng(8)
    covered = 0
    for _ in range(300):
        found = interquartile_mean([rng.standard_normal(16), rng.standard_normal(16)])
        covered += found.low <= 0 <= found.high
    assert 0.90 <= covered / 300 <= 0.985


def test_one_run_a_task_has_no_interval() -> None:
    for found in (
        interquartile_mean(arrays([1.0, 2.0], [3.0])),
        probability_of_improvement(arrays([1.0]), arrays([2.0, 3.0]), seeds(1), seeds(2)),
    ):
        assert math.isfinite(found.value)
        assert math.isnan(found.low)
        assert math.isnan(found.high)


def test_probability_of_improvement_by_hand() -> None:
    """Task 1: of (1, 3) x (2, 3), x wins 1 pair and ties 1 of 4; task 2: always."""
    x, y = arrays([1, 3], [9, 9]), arrays([2, 3], [0, 1])
    found = probability_of_improvement(x, y, seeds(2, 2), seeds(2, 2))
    assert found.value == pytest.approx((1.5 / 4 + 1) / 2)


def test_probability_of_improvement_is_mann_whitney() -> None:
    rng = np.random.default_rng(2)
    x, y = rng.integers(0, 5, 16).astype(float), rng.integers(1, 6, 12).astype(float)
    found = probability_of_improvement([x], [y], seeds(16), seeds(12))
    assert found.value == pytest.approx(stats.mannwhitneyu(x, y).statistic / (16 * 12))
    turned = probability_of_improvement([y], [x], seeds(12), seeds(16))
    assert turned.value == pytest.approx(1 - found.value)
    assert found.low < found.value < found.high


def test_pairs_of_equal_seed() -> None:
    """Seeds 2 and 3 are common: 5 > 4 and 7 < 8."""
    found = paired_probability_of_improvement(
        arrays([1, 5, 7]), arrays([8, 9, 4]), [(1, 2, 3)], [(3, 4, 2)]
    )
    assert found is not None
    assert found.value == 0.5
    nothing = paired_probability_of_improvement(arrays([1]), arrays([1]), [(1,)], [(2,)])
    assert nothing is None


def test_pairing_narrows_the_interval_of_equal_runs() -> None:
    """x is y and a little more: paired, every seed agrees that x is better."""
    y = np.random.default_rng(4).standard_normal(16)
    x = y + 0.01
    paired = paired_probability_of_improvement([x], [y], seeds(16), seeds(16))
    assert paired is not None
    assert (paired.value, paired.high) == pytest.approx((1.0, 1.0))
    assert probability_of_improvement([x], [y], seeds(16), seeds(16)).value < 0.6


@pytest.mark.parametrize("n", [2, 3, 16])
@pytest.mark.parametrize("tasks", [1, 3])
def test_pairs_that_are_all_won_leave_doubt(n: int, tasks: int) -> None:
    """As much as Wilson's interval of so many pairs has, whoever is named first."""
    x, y = arrays(*[[2.0] * n] * tasks), arrays(*[[1.0] * n] * tasks)
    both = [seeds(*[n] * tasks)] * 2
    expected = stats.binomtest(n * tasks, n * tasks).proportion_ci(method="wilson")
    for found in (
        probability_of_improvement(x, y, *both), paired_probability_of_improvement(x, y, *both)
    ):  # fmt: skip
        assert found is not None
        assert (found.value, found.low, found.high) == pytest.approx((1.0, *expected))
    lost = probability_of_improvement(y, x, *both)
    assert (lost.low, lost.high) == pytest.approx((0.0, 1 - expected.low), abs=1e-12)


def test_fewer_pairs_in_one_task_leave_more_doubt() -> None:
    x, y = arrays([2.0] * 16, [2.0] * 2), arrays([1.0] * 16, [1.0] * 2)
    found = probability_of_improvement(x, y, seeds(16, 2), seeds(16, 2))
    effective = 4 / (1 / 16 + 1 / 2)
    assert found.low == pytest.approx(effective / (effective + stats.norm.ppf(0.975) ** 2))


def test_profile_by_hand() -> None:
    """Above 0.5: two of three and one of two; the mean of the shares, not of the runs."""
    profile = performance_profile(arrays([0.5, 0.6, 0.7], [0.1, 0.9]), np.array([0.0, 0.5, 1.0]))
    assert profile.share.tolist() == [1.0, pytest.approx((2 / 3 + 1 / 2) / 2), 0.0]
    assert (profile.low <= profile.share).all()
    assert (profile.share <= profile.high).all()
    assert np.isnan(performance_profile(arrays([0.5]), np.zeros(3)).low).all()
