"""Mean ranks, by hand and against scipy."""

import math

import numpy as np
import pytest
import scipy.stats

from service.analysis.statistics.mean_rank import mean_ranks
from service.analysis.statistics.stratified_bootstrap import RESAMPLES, draw_counts


def test_worked_by_hand() -> None:
    """In one task 1, 2, 3; in the other 2.5, 1, 2.5, the first and the last being equal."""
    found = mean_ranks([
        {"CartPole": np.array([3.0, 5.0]), "Pendulum": np.array([0.0, 0.0])},
        {"CartPole": np.array([2.0, 2.0]), "Pendulum": np.array([1.0, 1.0])},
        {"CartPole": np.array([1.0, 1.0]), "Pendulum": np.array([0.0, 0.0])},
    ])  # fmt: skip
    assert [each.value for each in found] == [1.75, 1.5, 2.75]


def test_whoever_is_not_in_a_task_is_not_ranked_there() -> None:
    found = mean_ranks([
        {"CartPole": np.array([1.0, 1.0])},
        {"CartPole": np.array([2.0, 2.0]), "Acrobot": np.array([0.0, 0.0])},
        {},
    ])  # fmt: skip
    assert [each.value for each in found[:2]] == [2.0, 1.0]
    assert math.isnan(found[2].value)


def test_intervals_are_those_of_scipys_ranks_of_resampled_means() -> None:
    draws = np.random.default_rng(0)
    tasks = ["CartPole", "Pendulum", "Acrobot"]
    scores = [{task: draws.normal(k, 2.0, 8) for task in tasks} for k in range(4)]
    means = np.array([
        [draw_counts(8, place) @ own[task] / 8 for place, task in enumerate(tasks)]
        for own in scores
    ])  # fmt: skip
    assert means.shape == (4, 3, RESAMPLES)
    ranks = scipy.stats.rankdata(-means, axis=0).mean(axis=1)
    for k, found in enumerate(mean_ranks(scores)):
        assert (found.low, found.high) == pytest.approx(np.quantile(ranks[k], (0.025, 0.975)))
        assert found.low <= found.value <= found.high


def test_a_single_run_has_no_interval() -> None:
    [one, _] = mean_ranks([{"CartPole": np.array([1.0])}, {"CartPole": np.array([0.0, 0.0])}])
    assert one.value == 1.0
    assert math.isnan(one.low)
