"""Gains at equal cost, against numbers worked out by hand."""

import json

import numpy as np
import pytest
import scipy.stats

from algorithms import catalogue
from service.paper.differences import gains, mean_gain
from service.paper.evaluation import TASKS, row
from service.paper.measured import MeasuredRun, Scale
from workers.messages.run_spec import Weights


def run(
    algorithm: str,
    seed: int,
    returns: list[float],
    jacobians: int = 0,
    seconds: float = 1.0,
    *,
    environment: str = "Pendulum",
    status: str = "succeeded",
    config: str = "{}",
    processor: str = "znver5",
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
    settings, extended = json.loads(config), catalogue.baseline(algorithm)
    names = row(algorithm, settings), row(extended, settings) if extended else ""
    spec = (environment, algorithm, *names, Weights(), seed, 1000)
    return MeasuredRun(*spec, status, processor, columns)


def scales(unit: float, *tasks: str) -> dict[str, Scale]:
    return {task: Scale(0.0, unit) for task in tasks or ["Pendulum"]}


def test_equal_timesteps_compare_whole_curves() -> None:
    runs = [
        run("ddpg", 0, [0, 0, 0, 0]),
        run("ddpg", 1, [0, 0, 0, 0]),
        run("hybrid-ddpg", 0, [1, 1, 1, 1]),
        run("hybrid-ddpg", 1, [-3, -3, -3, -3]),
        run("hybrid-ddpg", 2, [9, 9, 9, 9]),
    ]
    by_cost = {gain.cost: gain for gain in gains(runs, scales(2.0))}
    gain = by_cost["timesteps"]
    assert (gain.n, gain.wins, gain.mean.value) == (2, 1, -0.5)
    assert (gain.mean.low, gain.mean.high) == (-1.5, 0.5)


def test_seconds_of_two_processors_are_not_compared() -> None:
    runs = [run(name, seed, [1, 1]) for name in ("ddpg", "hybrid-ddpg") for seed in range(3)]
    runs.append(run("ddpg", 3, [1, 1], processor="znver3"))
    runs.append(run("hybrid-ddpg", 3, [1, 1]))
    by_cost = {gain.cost: gain.n for gain in gains(runs, scales(2.0))}
    assert by_cost == {"timesteps": 4, "evaluations": 4, "seconds": 3}


def test_jacobians_and_seconds_count_against_the_hybrid() -> None:
    """With a Jacobian a step, and two seconds for one, it is cut at half its curve."""
    baseline = run("ddpg", 0, [0, 1, 2, 3])
    hybrid = run("hybrid-ddpg", 0, [0, 1, 2, 3], jacobians=1, seconds=2.0)
    by_cost = {gain.cost: gain for gain in gains([baseline, hybrid], scales(1.0))}
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
    assert {(gain.n, gain.mean.value) for gain in gains(runs, scales(1.0))} == {(1, 1.0)}


def test_without_a_baseline_there_is_no_gain() -> None:
    assert not list(gains([run("hybrid-ddpg", 0, [1]), run("mpc", 0, [1])], scales(1.0)))


def test_pairs_with_a_run_that_ended_early_are_told_and_do_not_count() -> None:
    """Of a run that goes on yet nothing is told."""
    runs = [
        *(run("ddpg", seed, [0, 0]) for seed in range(4)),
        run("hybrid-ddpg", 0, [1, 1]),
        run("hybrid-ddpg", 1, [9, 9], status="diverged"),
        run("hybrid-ddpg", 2, [9, 9], status="failed"),
        run("hybrid-ddpg", 3, [9, 9], status="running"),
    ]
    assert {(gain.n, gain.failed, gain.mean.value) for gain in gains(runs, scales(1.0))} == {
        (1, 2, 1.0)
    }


def test_the_baseline_is_of_the_same_form_and_may_have_settings_of_its_own() -> None:
    learned = '{"temperature": "learned"}'
    runs = [
        run("sac", 0, [0, 0], config=learned),
        run("sac", 0, [1, 1], config='{"reward_scale": 3.0}'),
        run("hybrid-sac", 0, [3, 3], config='{"reward_scale": 10.0}'),
    ]
    assert {gain.mean.value for gain in gains(runs, scales(1.0))} == {2.0}
    runs[2] = run("hybrid-sac", 0, [3, 3], config=learned)
    assert {gain.mean.value for gain in gains(runs, scales(1.0))} == {3.0}


def test_p_is_corrected_for_the_papers_seven_tasks() -> None:
    """Ten wins of ten have p = 2 / 2^10; of two such tasks the first counts 7 times, the next 6."""
    tasks = {"CartPole": 1.0, "Pendulum": 2.0, "Acrobot": 0.0}
    runs = [
        run(algorithm, seed, [height, height], environment=task)
        for task, gained in tasks.items()
        for seed in range(10)
        for algorithm, height in (("ddpg", 0.0), ("hybrid-ddpg", gained))
    ]
    found = {
        gain.environment: gain
        for gain in gains(runs, scales(1.0, *tasks))
        if gain.cost == "timesteps"
    }
    assert list(found) == [task for task in TASKS if task in tasks]
    p = {task: (gain.p, gain.corrected_p) for task, gain in found.items()}
    least = 2 / 2**10
    assert p == {
        "CartPole": (least, 7 * least), "Pendulum": (least, 7 * least), "Acrobot": (1.0, 1.0)
    }  # fmt: skip
    verdicts = {task: gain.verdict for task, gain in found.items()}
    assert verdicts == {
        "CartPole": "better", "Pendulum": "better", "Acrobot": "not told apart"
    }  # fmt: skip


def test_a_hybrid_that_loses_is_behind() -> None:
    runs = [
        run(algorithm, seed, [height, height])
        for seed in range(10)
        for algorithm, height in (("td3", 1.0), ("hybrid-td3", 0.0))
    ]
    assert {gain.verdict for gain in gains(runs, scales(1.0))} == {"behind"}


def test_more_tasks_are_a_family_of_their_own() -> None:
    runs = [
        run(algorithm, seed, [height, height], environment="Hopper")
        for seed in range(10)
        for algorithm, height in (("td3", 0.0), ("hybrid-td3", 1.0))
    ]
    assert {gain.corrected_p for gain in gains(runs, scales(1.0, "Hopper"))} == {3 * 2 / 2**10}


def test_simultaneous_intervals_are_bonferronis() -> None:
    draws = np.random.default_rng(0)
    theirs, ours = draws.standard_normal(12), draws.standard_normal(12)
    runs = [
        run(algorithm, seed, [value, value])
        for algorithm, values in (("ddpg", theirs), ("hybrid-ddpg", ours))
        for seed, value in enumerate(values)
    ]
    at_once = gains(runs, scales(1.0))[0].simultaneous
    expected = scipy.stats.ttest_1samp(ours - theirs, 0).confidence_interval(1 - 0.05 / 7)
    assert (at_once.low, at_once.high) == pytest.approx((expected.low, expected.high), rel=1e-9)


def test_the_interval_covers_as_often_as_it_says() -> None:
    """Of 400 samples of 16 normal numbers, about 93 % (percentiles are a little narrow)."""
    draws = np.random.default_rng(0).standard_normal((400, 16))
    estimates = [mean_gain(sample) for sample in draws]
    covered = np.mean([each.low < 0 < each.high for each in estimates])
    assert covered == pytest.approx(0.93, abs=0.03)
