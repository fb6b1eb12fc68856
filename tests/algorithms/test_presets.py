"""What a run gets that names nothing, on every task, also on one of one's own."""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import algorithms
import physics
from algorithms import catalogue
from algorithms.measurement import Measurement
from algorithms.presets import CHOSEN, FORMS, completed, preset
from tests.algorithms.other_rewards import times

TASKS = [*physics.names(), "OnesOwn"]
HYBRIDS = [name for name, table in CHOSEN.items() if "weights" in table]
PENDULUM = CHOSEN["ddpg"]["settings"]["Pendulum"]
OF_THE_PAPER = [name for name in HYBRIDS if "settings" not in CHOSEN[name]]


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("hybrid", HYBRIDS)
def test_a_hybrid_matches_on_every_task_for_its_baselines_timesteps(hybrid: str, task: str) -> None:
    chosen, baseline = preset(hybrid, task), preset(catalogue.baseline(hybrid), task)
    assert max(chosen.weights) > 0
    assert min(chosen.weights) >= 0
    assert chosen.timesteps == baseline.timesteps
    if hybrid in OF_THE_PAPER:
        assert chosen.config == baseline.config


@pytest.mark.parametrize("hybrid", HYBRIDS)
def test_a_hybrid_on_ones_own_task_is_not_its_baseline(hybrid: str) -> None:
    task = times("Pendulum", 1.0)
    task.name = "OnesOwn"  # type: ignore[misc]  # a task that no preset knows
    curves = [
        [m.return_mean for m in algorithms.train(name, task, [0], timesteps=1_600)]
        for name in (hybrid, catalogue.baseline(hybrid))
    ]
    assert curves[0] != curves[1]


def test_exactly_what_extends_another_algorithm_has_weights() -> None:
    extending = {name for name, algorithm in catalogue.OWN.items() if algorithm.extends}
    assert extending == set(HYBRIDS)
    assert all(catalogue.find(name).uses_weights for name in extending)
    assert not any(catalogue.find(catalogue.baseline(name)).uses_weights for name in extending)
    assert catalogue.baseline("ddpg") == catalogue.baseline("no longer installed") == ""


def test_whoever_asks_for_no_weights_is_told_that_this_is_the_baseline() -> None:
    with pytest.warns(UserWarning, match=r"hybrid-sac with weights \(0, 0\) .* is sac, bit for"):
        algorithms.prepare("hybrid-sac", "Acrobot", [0], (0, 0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        algorithms.prepare("hybrid-sac", "Acrobot", [0])
        algorithms.prepare("ddpg", "Acrobot", [0], (0, 0))


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, PENDULUM),
        ({"gamma": 0.98}, {**PENDULUM, "gamma": 0.98}),
        ({"noise": 0.1}, {**PENDULUM, "noise": 0.1}),
    ],
)
def test_given_settings_stand_over_those_of_the_preset(
    given: Mapping[str, Any], expected: Mapping[str, Any]
) -> None:
    assert completed("ddpg", "Pendulum", given) == expected
    learner: Any = algorithms.build("ddpg", "Pendulum", [0], config=given)
    config = learner._agents[0]._config
    assert {name: getattr(config, name) for name in expected} == expected


def test_a_form_has_settings_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of the 2018 form are not for a learned temperature; a hybrid has its baseline's."""
    rows = {"other": {"tau": 0.02}, "Pendulum": {"tau": 0.01}}
    monkeypatch.setitem(CHOSEN, FORMS["sac"][0].row, {"settings": rows})
    for name in ("sac", "hybrid-sac"):
        assert completed(name, "Pendulum", {}) == preset("sac", "Pendulum").config
        given = {"temperature": "learned"}
        assert completed(name, "Pendulum", given) == {"temperature": "learned", "tau": 0.01}
        assert completed(name, "OnesOwn", given) == {"temperature": "learned", "tau": 0.02}
        assert completed(name, "Pendulum", {**given, "tau": 0.1}) == {**given, "tau": 0.1}


@pytest.mark.parametrize("name", FORMS)
def test_what_states_a_form_are_settings_of_its_learner(name: str) -> None:
    for form in FORMS[name]:
        for task in TASKS:
            catalogue.find(name).config_class()(**completed(name, task, form.stated))


@pytest.mark.parametrize("seeds", [np.arange(2), range(2), (0, np.int64(1)), {0, 1}])
def test_seeds_may_be_any_integers(seeds: Any) -> None:
    found = algorithms.train("ddpg", "MassPoint", seeds, timesteps=100)
    assert [(type(m.seed), m.seed) for m in found] == [(int, 0), (int, 1)]


@pytest.mark.parametrize("seeds", [[], [0, 0], [-1], [0.5], ["0"], np.array([0.0]), 3, None])
def test_other_seeds_are_refused_by_name(seeds: Any) -> None:
    with pytest.raises(ValueError, match="seeds must be different integers from 0 on, not"):
        algorithms.prepare("ddpg", "MassPoint", seeds)


@pytest.mark.parametrize("timesteps", [0, -1, float("nan"), float("inf"), 800.0, "800", True - 1])
def test_other_timesteps_are_refused_by_name(timesteps: Any) -> None:
    with pytest.raises(ValueError, match="timesteps must be an integer from 1 on, not"):
        algorithms.prepare("ddpg", "MassPoint", [0], timesteps=timesteps)


@pytest.mark.parametrize(
    "weights",
    [(1,), (1, 2, 3), (-1, 0), (float("nan"), 0), (float("inf"), 0), (1e300, 0), (0, 1e-300)],
)
def test_weights_that_float32_does_not_hold_are_refused_by_name(weights: Any) -> None:
    with pytest.raises(ValueError, match="weights must be two numbers, each 0 or from"):
        algorithms.prepare("hybrid-ddpg", "MassPoint", [0], weights)


@pytest.mark.parametrize("timesteps", [1, 500, 799, 800, 1_500])
@pytest.mark.parametrize("name", ["ddpg", "hybrid-ddpg", "sac", "gd", "shac", "ppo", "mpc"])
def test_a_run_is_measured_at_its_end_whatever_its_length(name: str, timesteps: int) -> None:
    learner = algorithms.build(name, "Pendulum", [0, 3], timesteps=timesteps)
    measured = []
    while not learner.finished:
        measured += learner.advance()
    grid = [*range(800, timesteps, 800), timesteps]
    for seed in (0, 3):
        mine = [m for m in measured if isinstance(m, Measurement) and m.seed == seed]
        assert [m.timestep for m in mine] == grid
        if name != "mpc":  # which also predicts between measurements
            returns = [m.return_mean for m in mine]
            assert mine[-1].return_history == pytest.approx(np.mean(returns))
