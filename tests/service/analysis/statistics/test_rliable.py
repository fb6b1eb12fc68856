"""Our statistics against rliable's definitions, on the published scores and on ties."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from service.analysis.statistics.score_statistics import (
    interquartile_mean,
    performance_profile,
    probability_of_improvement,
)
from service.paper.evaluation import SEEDS, TASKS
from tests.service.analysis.statistics import rliable
from tests.service.analysis.statistics.rliable import Floats
from tests.service.paper import published

THRESHOLDS = np.linspace(-1.0, 1.0, 41)
ALGORITHMS = ("ddpg", "hybrid-ddpg", "hybrid-ddpg-cosine")
SHAPES = st.tuples(st.just(2), st.integers(1, 12), st.integers(1, 5))
TIED = arrays.arrays(np.float64, SHAPES, elements=st.integers(-3, 3).map(lambda k: k / 4))
"""Scores of two algorithms [2, runs, tasks], of seven values only."""


def by_task(scores: Floats) -> list[Floats]:
    return [np.ascontiguousarray(task) for task in scores.T]


def seeds_of(scores: Floats) -> list[tuple[int, ...]]:
    return [tuple(range(len(scores)))] * scores.shape[1]


def ours_beats_theirs(ours: Floats, theirs: Floats) -> float:
    return probability_of_improvement(
        by_task(ours), by_task(theirs), seeds_of(ours), seeds_of(theirs)
    ).value


def assert_equal(ours: Floats, theirs: Floats) -> None:
    assert interquartile_mean(by_task(ours)).value == pytest.approx(
        rliable.aggregate_iqm(ours), abs=1e-12
    )
    assert ours_beats_theirs(ours, theirs) == pytest.approx(
        rliable.probability_of_improvement(ours, theirs), abs=1e-12
    )
    profile = performance_profile(by_task(ours), THRESHOLDS)
    shares = [rliable.run_score_deviation(ours, threshold) for threshold in THRESHOLDS]
    np.testing.assert_allclose(profile.share, shares, atol=1e-12)


@settings(deadline=None)
@given(TIED)
def test_on_scores_with_ties(both: Floats) -> None:
    assert_equal(*both)
    assert_equal(both[0], both[0])


def test_on_random_scores() -> None:
    draws = np.random.default_rng(0)
    for runs in range(2, 20):
        assert_equal(*draws.standard_normal((2, runs, 7)))


def published_scores(algorithm: str) -> Floats:
    cells = (published.cell(task, algorithm) for task in TASKS)
    return np.stack([published.scores(cell, "return_history") for cell in cells], axis=1)


@pytest.mark.parametrize(("x", "y"), list(combinations(ALGORITHMS, 2)))
def test_on_the_published_scores(x: str, y: str) -> None:
    ours, theirs = published_scores(x), published_scores(y)
    assert ours.shape == theirs.shape == (SEEDS, len(TASKS))
    assert_equal(ours, theirs)
    assert_equal(theirs, ours)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_intervals_are_those_of_its_bootstrap(algorithm: str) -> None:
    """Other draws: the ends differ by what 2,000 resamples leave open, some 5 % of the width."""
    scores = published_scores(algorithm)
    estimate = interquartile_mean(by_task(scores))
    low, high = rliable.interval(scores, rliable.aggregate_iqm)
    assert (estimate.low, estimate.high) == pytest.approx((low, high), abs=0.12 * (high - low))
    profile = performance_profile(by_task(scores), np.array([0.5]))
    low, high = rliable.interval(scores, lambda each: rliable.run_score_deviation(each, 0.5))
    assert (profile.low[0], profile.high[0]) == pytest.approx((low, high), abs=0.02)
