"""Gains at equal cost, against numbers worked out by hand."""

import numpy as np
import pytest

from service.paper.differences import MeasuredRun, gains, mean_gain
from workers.messages.run_spec import Weights


def run(
    algorithm: str, seed: int, returns: list[float], jacobians: int = 0, seconds: float = 1.0
) -> MeasuredRun:
    """A run measured every 100 timesteps, at a steady cost."""
    steps = 100.0 * np.arange(1, len(returns) + 1)
    columns = {
        "timestep": steps,
        "return_mean": np.array(returns),
        "updates": steps,
        "jacobians": steps * jacobians,
        "seconds": steps / 100 * seconds,
    }
    return MeasuredRun(algorithm, "Pendulum", Weights(), seed, columns)


def test_equal_timesteps_compare_whole_curves() -> None:
    runs = [
        run("ddpg", 0, [0, 0, 0, 0]),
        run("ddpg", 1, [0, 0, 0, 0]),
        run("hybrid-ddpg", 0, [1, 1, 1, 1]),
        run("hybrid-ddpg", 1, [-3, -3, -3, -3]),
        run("hybrid-ddpg", 2, [9, 9, 9, 9]),
    ]
    by_cost = {gain.cost: gain for gain in gains(runs, {"Pendulum": 2.0})}
    gain = by_cost["timesteps"]
    assert (gain.n, gain.wins, gain.mean.value) == (2, 1, -0.5)
    assert (gain.mean.low, gain.mean.high) == (-1.5, 0.5)


def test_jacobians_and_seconds_count_against_the_hybrid() -> None:
    """With a Jacobian a step, and two seconds for one, it is cut at half its curve."""
    baseline = run("ddpg", 0, [0, 1, 2, 3])
    hybrid = run("hybrid-ddpg", 0, [0, 1, 2, 3], jacobians=1, seconds=2.0)
    by_cost = {gain.cost: gain for gain in gains([baseline, hybrid], {"Pendulum": 1.0})}
    assert by_cost["timesteps"].mean.value == 0.0
    assert by_cost["evaluations"].mean.value == 0.5 - 1.5
    assert by_cost["seconds"].mean.value == 0.5 - 1.5


def test_a_run_that_is_not_finite_or_has_not_begun_does_not_count() -> None:
    runs = [
        run("ddpg", 0, [0, 0]),
        run("ddpg", 1, [0, 0]),
        run("ddpg", 2, []),
        run("hybrid-ddpg", 0, [1, 1]),
        run("hybrid-ddpg", 1, [1, np.inf]),
        run("hybrid-ddpg", 2, [1, 1]),
    ]
    assert {(gain.n, gain.mean.value) for gain in gains(runs, {"Pendulum": 1.0})} == {(1, 1.0)}


def test_without_a_baseline_there_is_no_gain() -> None:
    assert not list(gains([run("hybrid-ddpg", 0, [1]), run("mpc", 0, [1])], {"Pendulum": 1.0}))


def test_the_interval_covers_as_often_as_it_says() -> None:
    """Of 400 samples of 16 normal numbers, about 93 % (percentiles are a little narrow)."""
    draws = np.random.default_rng(0).standard_normal((400, 16))
    estimates = [mean_gain(sample) for sample in draws]
    covered = np.mean([each.low < 0 < each.high for each in estimates])
    assert covered == pytest.approx(0.93, abs=0.03)
