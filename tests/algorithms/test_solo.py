"""Runs that act and learn by themselves: what their author may rely on, and is told."""

from typing import Any

import numpy as np
import pytest
from pydantic.dataclasses import dataclass

import algorithms
from algorithms.early_end import DivergedError, FailedRunsError
from algorithms.learner import Learner
from algorithms.settings import STRICT, ActivationName, HiddenLayers, HiddenUnits
from algorithms.solo import SoloLearner, SoloRun, builder_of
from algorithms.state import Saved


@dataclass(frozen=True, config=STRICT)
class Settings:
    hidden_units: HiddenUnits = 4
    hidden_layers: HiddenLayers = 1
    activation: ActivationName = "tanh"
    value: float = 0.5


class Walk(SoloRun[Settings]):
    """Adds a number to every parameter."""

    learned = ("theta", "reached")

    def begin(self) -> None:
        self.theta = np.zeros(21, np.float32)
        self.reached = 0.0

    def explore(self) -> Any:
        return self.returns_of(np.stack([self.theta, self.theta + 1]))

    def improve(self, lived: Any) -> None:
        assert lived.shape == (2,)
        self.theta = self.theta + np.float32(self.config.value)
        self.reached += self.config.value


class Idle(Walk):
    def explore(self) -> Any:
        return np.zeros(2)


class Double(Walk):
    def improve(self, lived: Any) -> None:
        self.theta = self.theta.astype(np.float64)


class Lost(Walk):
    def improve(self, lived: Any) -> None:
        self.theta = self.theta * np.float32(np.nan)


build_walk, build_idle, build_double, build_lost = map(builder_of, (Walk, Idle, Double, Lost))


def algorithm(name: str) -> algorithms.Algorithm:
    return algorithms.Algorithm(
        name, "A test's", builder=f"{__name__}:build_{name}", config=f"{__name__}:Settings"
    )


def built(**config: Any) -> Learner:
    return algorithms.build(algorithm("walk"), "MassPoint", [0, 1], timesteps=2_000, config=config)


def saved(learner: Learner) -> dict[int, Saved]:
    return {s: Saved(learner.state(s), learner.journal(s, 0)) for s in learner.seeds}


def test_steps_are_counted_and_measurements_are_of_the_policy_that_took_them() -> None:
    learner = built()
    assert isinstance(learner, SoloLearner)
    learner.advance()
    run = learner._runs[0]
    assert 0 < run.timestep <= 2 * run.environment.horizon
    assert (run.updates, float(run.theta[0])) == (1, 0.5)


def test_numbers_and_arrays_are_taken_up() -> None:
    learner, again = built(), built()
    learner.advance()
    again.restore(saved(learner))
    assert isinstance(again, SoloLearner)
    assert getattr(again._runs[1], "reached") == 0.5  # noqa: B009 - of the class here
    for name, array in learner.state(1).items():
        np.testing.assert_array_equal(again.state(1)[name], array, strict=True)


def test_a_state_of_other_sizes_is_refused() -> None:
    state = saved(built())
    other = {
        seed: Saved({**each.state, "learned/theta": np.zeros(5, np.float32)}, {})
        for seed, each in state.items()
    }
    with pytest.raises(ValueError, match="of other settings or other code"):
        built().restore(other)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("idle", r"Idle.explore counted no environment steps: it has to add them to self.timestep"),
        ("double", r"Double: theta must be float32 \[21\], not float64 \[21\]"),
    ],
)
def test_mistakes_of_the_author_are_told(name: str, reason: str) -> None:
    with pytest.raises(FailedRunsError, match=reason):
        algorithms.train(algorithm(name), "MassPoint", [0], timesteps=2_000).run()


def test_a_theta_that_is_not_finite_is_a_divergence() -> None:
    with pytest.raises(DivergedError, match="seed 0 diverged: theta not finite at update"):
        algorithms.train(algorithm("lost"), "MassPoint", [0], timesteps=2_000).run()
