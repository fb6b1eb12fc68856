"""A run's curve depends on its spec alone."""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import algorithms
from algorithms import catalogue
from algorithms.measurement import Measurement
from algorithms.presets import preset
from physics.environment import Environment
from tests.physics.small_tasks import Plain

Curve = list[tuple[int, float, float]]
TIMESTEPS = 1_600
WEIGHTS = {
    "ddpg": (0.0, 0.0),
    "hybrid-ddpg": (0.1, 0.01),
    "hybrid-ddpg-cosine": (0.1, 0.01),
    "hybrid-ddpg-robust": (1.0, 0.1),
    "td3": (0.0, 0.0),
    "hybrid-td3": (1.0, 0.1),
    "sac": (0.0, 0.0),
    "hybrid-sac": (0.1, 0.01),
    "gd": (0.0, 0.0),
    "shac": (0.0, 0.0),
    "ppo": (0.0, 0.0),
}
CONFIG = {name: {"environments": 4, "window": 20} for name in ("shac", "ppo")}


def curves(
    name: str,
    seeds: list[int],
    weights: tuple[float, float] | None = None,
    config: Mapping[str, Any] | None = None,
) -> dict[int, Curve]:
    found: dict[int, Curve] = {seed: [] for seed in seeds}
    pair = WEIGHTS[name] if weights is None else weights
    settings = CONFIG.get(name) if config is None else config
    for m in algorithms.train(name, "Pendulum", seeds, pair, TIMESTEPS, settings):
        found[m.seed].append((m.timestep, m.return_mean, m.return_history))
    return found


@pytest.mark.parametrize("name", WEIGHTS)
def test_alone_and_in_a_cohort_the_same_bits(name: str) -> None:
    """Of sixteen, the most there are, where that is quick; the size is the same code for all."""
    cohort = curves(name, list(range(16 if name in ("ddpg", "gd", "shac", "ppo") else 3)))
    assert curves(name, [1]) == {1: cohort[1]}
    assert cohort[1] != cohort[2]


@pytest.mark.parametrize(
    ("hybrid", "plain"),
    [
        ("hybrid-ddpg", "ddpg"),
        ("hybrid-ddpg-cosine", "ddpg"),
        ("hybrid-ddpg-robust", "ddpg"),
        ("hybrid-td3", "td3"),
        ("hybrid-sac", "sac"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*matches no gradients")
def test_hybrid_without_weights_is_the_plain_learner(hybrid: str, plain: str) -> None:
    """With the same settings: the search may have chosen others for each."""
    same = preset(plain, "Pendulum").config
    assert curves(hybrid, [0, 1], (0.0, 0.0), same) == curves(plain, [0, 1])
    assert curves(hybrid, [0, 1], None, same) != curves(plain, [0, 1])


def test_dropped_neighbours_change_nothing() -> None:
    whole = curves("hybrid-ddpg", [0, 1, 2])
    learner = algorithms.build("hybrid-ddpg", "Pendulum", [0, 1, 2], (0.1, 0.01), TIMESTEPS, {})
    found: Curve = []
    while not learner.finished:
        events = learner.advance()
        found += [(m.timestep, m.return_mean, m.return_history) for m in events if m.seed == 1]  # type: ignore[union-attr]
        if learner.timestep == 800:
            learner.drop([0, 2])
    assert found == whole[1]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_kernels_just_compiled_and_kernels_from_the_cache_the_same_bits(tmp_path: Path) -> None:
    program = (
        "import algorithms\n"
        "for name, w in (('ddpg', (0, 0)), ('hybrid-ddpg', (1, 0.1))):\n"
        "    for m in algorithms.train(name, 'Pendulum', [0, 1], w, 1600, {}):\n"
        "        print(m.seed, m.timestep, repr(m.return_mean))\n"
    )
    first, second = (
        subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ | {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": os.getcwd()},
            capture_output=True,
            check=True,
        ).stdout
        for _ in range(2)
    )
    assert first == second
    assert first.count(b"\n") == 8


@pytest.mark.parametrize("task", [Plain, Plain()], ids=["a class", "an instance"])
def test_a_task_may_be_an_object(task: Environment | type[Environment]) -> None:
    measured = [m.timestep for m in algorithms.train("ddpg", task, [0], timesteps=800)]
    assert measured == [800]


def test_what_is_no_task_is_refused() -> None:
    with pytest.raises(ValueError, match=r"or an instance of Environment, not 3$"):
        algorithms.build("ddpg", 3, [0])  # type: ignore[arg-type]


@pytest.mark.parametrize("name", [name for name in WEIGHTS if catalogue.find(name).uses_weights])
def test_a_hybrid_may_match_in_some_updates_only(name: str) -> None:
    """The updates between report a gradient loss of 0, and the curve is another one."""

    def trained(config: dict[str, Any]) -> Measurement:
        *_, last = algorithms.train(name, "MassPoint", [0], WEIGHTS[name], 800, config)
        return last

    always, seldom = trained({}), trained({"match_every": 400})
    assert always.return_mean != seldom.return_mean
    assert 0 < seldom.diagnostics["gradient_loss"] < always.diagnostics["gradient_loss"]
