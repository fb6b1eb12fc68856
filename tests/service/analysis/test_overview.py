"""Learners over many tasks, by hand."""

import numpy as np
import pytest
import scipy.stats

from service.analysis.overview import SHARES, TIMES, Learner, SharedRun, standings

STEPS = np.linspace(0.04, 1.0, 25)


def run(returns: float | np.ndarray, steps: np.ndarray = STEPS, cost: float = 1.0) -> SharedRun:
    """A run of steady cost; `cost` of the whole in runs of the reference."""
    return SharedRun(steps, cost * steps, returns + np.zeros(len(steps)))


def learner(label: str, **runs: list[SharedRun]) -> Learner:
    return Learner(label, label, runs)


def test_a_line_is_the_interquartile_mean_of_all_runs_of_all_tasks() -> None:
    heights = np.random.default_rng(0).random(12)
    tasks = {"CartPole": heights[:8], "Pendulum": heights[8:]}
    [one] = standings([learner("ddpg", **{
        task: [run(height * STEPS) for height in own] for task, own in tasks.items()
    })])  # fmt: skip
    assert (one.tasks, one.runs) == (2, 12)
    np.testing.assert_array_equal(one.by_timesteps.x, SHARES)
    expected = scipy.stats.trim_mean(heights, 0.25) * SHARES
    np.testing.assert_allclose(one.by_timesteps.mean, expected)
    assert (one.by_timesteps.low < expected).all()
    assert (one.by_timesteps.high > expected).all()


def test_values_lie_between_measurements_and_stay_after_the_last() -> None:
    """Measured at 0.5 and 0.7 alone: 0 and 1. There is none before, half at 0.6, 1 after."""
    [one] = standings([
        learner("gd", CartPole=[run(np.array([0.0, 1.0]), steps=np.array([0.5, 0.7]))] * 2)
    ])  # fmt: skip
    line = one.by_timesteps
    at = dict(zip(line.x.round(2), line.mean, strict=True))
    assert min(at) == 0.52
    assert at[0.6] == pytest.approx(0.5)
    assert at[0.72] == at[1.0] == 1.0


def test_a_run_without_a_value_yet_leaves_the_line_out() -> None:
    late = run(np.array([1.0, 1.0]), steps=np.array([0.5, 1.0]))
    [one] = standings([learner("ddpg", CartPole=[run(0.0), run(0.0)], Pendulum=[late, late])])
    assert one.by_timesteps.x.min() == pytest.approx(0.52)


def test_dear_learners_come_late() -> None:
    cheap, dear = standings([
        learner("ddpg", CartPole=[run(STEPS), run(STEPS)]),
        learner("sac", CartPole=[run(STEPS, cost=4.0), run(STEPS, cost=4.0)]),
    ])  # fmt: skip
    assert cheap.by_timesteps.mean == pytest.approx(dear.by_timesteps.mean)
    assert dear.by_time.x.min() > cheap.by_time.x.min()
    np.testing.assert_allclose(dear.by_time.mean, np.minimum(dear.by_time.x / 4.0, 1.0))
    assert cheap.by_time.x.max() == TIMES.max(), "what has ended keeps its last value"


def test_ranks_go_by_the_whole_curve() -> None:
    """Equal at the end; the first was there sooner."""
    soon, late = run(np.minimum(2 * STEPS, 1.0)), run(STEPS)
    found = standings([learner("sac", CartPole=[late] * 2), learner("ppo", CartPole=[soon] * 2)])
    assert [one.rank.value for one in found] == [2.0, 1.0]
