"""A run that was left and taken up again goes on to the same bits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import algorithms
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.state import Saved, State

TIMESTEPS = 1_600
NOISY = "Pendulum(observation_noise=0.1, process_noise=0.1)"
# name, environment, weights, config: a ring that wraps, ends by time, ends by themselves
CASES: list[tuple[str, str, tuple[float, float], dict[str, Any]]] = [
    ("ddpg", "Pendulum", (0.0, 0.0), {"time_limit_is_terminal": True}),
    ("hybrid-ddpg", "Pendulum", (0.1, 0.01), {}),
    ("hybrid-ddpg", "Pendulum", (0.1, 0.01), {"replay_size": 250}),
    ("hybrid-ddpg", "CartPole", (0.1, 0.01), {}),
    ("sac", "Pendulum", (0.0, 0.0), {}),
    ("td3", "CartPole", (0.0, 0.0), {"uniform_steps": 850}),
    ("hybrid-sac", "CartPole", (0.1, 0.01), {"replay_size": 250}),
    ("hybrid-ddpg", NOISY, (0.1, 0.01), {"replay_size": 250}),
]


def learner_of(case: int, seeds: list[int]) -> Learner:
    name, environment, weights, config = CASES[case]
    return algorithms.build(name, environment, seeds, weights, TIMESTEPS, config)


def saved_runs(learner: Learner) -> dict[int, Saved]:
    return {
        seed: Saved(copied(learner.state(seed)), copied(learner.journal(seed, 0)))
        for seed in learner.seeds
    }


def copied(state: State) -> State:
    return {name: array.copy() for name, array in state.items()}


def curves(learner: Learner) -> list[Measurement]:
    """What is measured from here to the end, but for the time it took."""
    found = []
    while not learner.finished:
        events = learner.advance()
        assert all(isinstance(event, Measurement) for event in events)
        found += [timeless(event) for event in events if isinstance(event, Measurement)]
    return found


def timeless(measurement: Measurement) -> Measurement:
    return replace(measurement, seconds=0.0, compile_seconds=0.0)


@pytest.mark.parametrize("case", range(len(CASES)))
def test_taken_up_alone_or_together_a_run_goes_on_to_the_same_bits(case: int) -> None:
    learner = learner_of(case, [3, 5, 8])
    cut = int(np.random.default_rng(case).integers(1, 15))
    early: list[Measurement] = []
    for _ in range(cut):
        early += [m for m in learner.advance() if isinstance(m, Measurement)]
    left = saved_runs(learner)
    whole = curves(learner)
    last = saved_runs(learner)

    for seeds in ([3, 5, 8], [5]):
        again = learner_of(case, seeds)
        again.restore({seed: left[seed] for seed in seeds})
        assert again.timestep == 100 * cut
        assert curves(again) == [m for m in whole if m.seed in seeds]
        for seed, saved in saved_runs(again).items():
            assert_equal(saved, last[seed])


def assert_equal(one: Saved, other: Saved) -> None:
    for some, others in zip(one, other, strict=True):
        assert some.keys() == others.keys()
        for name in some.keys() - {"seconds", "compile_seconds"}:
            np.testing.assert_array_equal(some[name], others[name], err_msg=name, strict=True)


def test_the_time_of_an_earlier_life_counts() -> None:
    learner = learner_of(1, [0])
    learner.advance()
    again = learner_of(1, [0])
    again.restore(saved_runs(learner))
    assert again.state(0)["seconds"] == learner.state(0)["seconds"] > 0
    assert again.state(0)["compile_seconds"] >= learner.state(0)["compile_seconds"]


def test_the_journal_goes_on_where_it_was_read_last() -> None:
    learner = learner_of(1, [0])
    for _ in range(3):
        learner.advance()
    whole, rest = learner.journal(0, 0), learner.journal(0, 200)
    assert len(whole["states"]) == 300
    for name, rows in whole.items():
        np.testing.assert_array_equal(rows[200:], rest[name], strict=True)


def test_a_state_of_other_settings_is_refused() -> None:
    learner = learner_of(1, [0])
    learner.advance()
    other = algorithms.build(
        "hybrid-ddpg", "Pendulum", [0], (0.1, 0.01), TIMESTEPS, {"hidden_units": 8}
    )
    with pytest.raises(ValueError, match="of other settings or other code"):
        other.restore(saved_runs(learner))


@pytest.mark.parametrize(
    ("name", "environment", "config"),
    [
        ("gd", "CartPole", {"episodes": 2}),
        ("shac", "CartPole", {"environments": 3, "window": 40, "critic_epochs": 2}),
        ("ppo", "Pendulum", {"environments": 3, "window": 70, "epochs": 2, "batches": 4}),
        ("mpc", "Pendulum", {"horizon": 10, "iterations": 3}),
        ("mpc", "MassPoint", {"horizon": 8, "iterations": 3}),
        ("mpc", NOISY, {"horizon": 10, "iterations": 3}),
        ("gd", NOISY, {"episodes": 2}),
        ("ppo", NOISY, {"environments": 3, "window": 70, "epochs": 2, "batches": 4}),
    ],
)
def test_those_without_a_replay_taken_up_at_different_moments_go_on_to_the_same_bits(
    name: str, environment: str, config: dict[str, Any]
) -> None:
    def built(seeds: list[int]) -> Learner:
        return algorithms.build(name, environment, seeds, (0.0, 0.0), 8_000, config)

    def said(learner: Learner, cycles: int) -> list[Measurement]:
        return [m for _ in range(cycles) for m in learner.advance() if isinstance(m, Measurement)]

    learner = built([3, 5, 8])
    said(learner, 7)
    first = saved_runs(learner)
    between = said(learner, 4)
    second = saved_runs(learner)
    rest = curves(learner)
    between = [timeless(m) for m in between]

    for seeds, saved in (([3, 5, 8], second), ([5], second), ([8, 5], {5: second[5], 8: first[8]})):
        again = built(seeds)
        again.restore({seed: saved[seed] for seed in seeds})
        found = curves(again)
        for seed in seeds:
            begun = between if saved[seed] is first[seed] else []
            expected = [m for m in begun + rest if m.seed == seed]
            assert [m for m in found if m.seed == seed] == expected != []
