"""Learning does not depend on the unit that a task's rewards are in."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import physics
from algorithms import catalogue
from algorithms.actor_critic.learner import OffPolicyLearner
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.on_policy.window_learner import WindowLearner
from physics.catalogue import OWN
from physics.environment import Environment
from tests.algorithms.other_rewards import OtherRewards, constant, times

REWARD_SCALE = 5.0


class Case(NamedTuple):
    """A learner with its weights."""

    name: str
    weights: tuple[float, float] = (0.0, 0.0)
    temperature: str = ""

    def settings(self, factor: float) -> dict[str, Any]:
        """SAC's fixed temperature is in the rewards' unit: it moves with it."""
        if self.temperature:
            return {"temperature": self.temperature}
        if self.name in ("shac", "ppo"):
            return {"environments": 4, "window": 25}
        return {"reward_scale": REWARD_SCALE / factor} if "sac" in self.name else {}


CASES = [
    Case("ddpg"),
    Case("hybrid-ddpg", (1.0, 0.1)),
    Case("hybrid-ddpg-cosine", (0.1, 0.1)),
    Case("sac"),
    Case("hybrid-ddpg-robust", (1.0, 0.1)),
    Case("td3"),
    Case("hybrid-td3", (1.0, 0.1)),
    Case("sac", temperature="learned"),
    Case("hybrid-sac", (0.1, 0.1)),
    Case("shac"),
    Case("ppo"),
]


def build(
    environment: Environment, case: Case, timesteps: int, factor: float = 1.0, **config: Any
) -> Any:
    algorithm = catalogue.find(case.name)
    settings = algorithm.config_class()(**case.settings(factor), **config)
    return algorithm.load()(environment, [0, 1], case.weights, timesteps, settings)


def first_losses(environment: Environment, case: Case) -> list[float]:
    """The mean critic loss of each run's first cycle."""
    learner = build(environment, case, 800)
    assert learner.advance() == []
    return critic_losses(learner)


def critic_losses(learner: Learner) -> list[float]:
    """The mean of each run's updates so far."""
    if isinstance(learner, WindowLearner):
        return [run._means.take()["critic_loss"] for run in learner._runs]
    assert isinstance(learner, OffPolicyLearner)
    return [agent.diagnose(100)["critic_loss"] for agent in learner._agents]


def actors(learner: Learner) -> list[NDArray[np.float32]]:
    """The parameters of each run's actor."""
    if isinstance(learner, WindowLearner):
        return [run.policy().theta for run in learner._runs]
    assert isinstance(learner, OffPolicyLearner)
    return [agent.policy().theta for agent in learner._agents]


@pytest.mark.parametrize(
    "case", [CASES[0], CASES[3], CASES[-2], CASES[-1]], ids=lambda case: case.name
)
@pytest.mark.parametrize("task", OWN)
def test_the_first_losses_of_the_critic_are_small_on_every_task(task: str, case: Case) -> None:
    assert max(first_losses(physics.make(task), case)) < 100.0


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize("reward", [-1.0, 0.0, 1e-6, 1e6])
def test_so_they_are_where_the_reward_is_constant(reward: float, case: Case) -> None:
    assert max(first_losses(constant("Pendulum", reward), case)) < 100.0


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_first_reward_after_many_alike_does_not_make_the_loss_enormous(case: Case) -> None:
    """The end of a long wait: -1 a step, hardly ever anything else, for 4,000 timesteps."""
    task = OtherRewards("Pendulum", lambda s, r: np.where(s[:, 1] > 6.0, 50.0, -1.0), 0.0)
    learner, losses = build(task, case, 4_000), []
    while not learner.finished:
        losses += [m.diagnostics["critic_loss"] for m in learner.advance()]
    assert len(losses) == 10
    assert max(losses) < 100.0


def curve(case: Case, task: str, factor: float, timesteps: int) -> list[tuple[int, int, float]]:
    learner = build(times(task, factor), case, timesteps, factor, hidden_units=16)
    measured = []
    while not learner.finished:
        for event in learner.advance():
            assert isinstance(event, Measurement)
            measured.append((event.seed, event.timestep, event.return_mean / factor))
    return measured


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize("task", ["Pendulum", "Acrobot", "HalfCheetah"])
def test_a_power_of_two_times_the_reward_changes_no_bit_of_a_curve(task: str, case: Case) -> None:
    """Such a factor is exact in floating point."""
    once = curve(case, task, 1.0, 2_000)
    assert curve(case, task, 1024.0, 2_000) == once
    assert curve(case, task, 2.0**-10, 2_000) == once


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_other_factors_change_no_more_than_rounding_does(factor: float, case: Case) -> None:
    """Held after the first cycle's updates: where rounding drifts to after many is chaos."""
    once, changed = (
        build(times("Pendulum", 1.0), case, 800),
        build(times("Pendulum", factor), case, 800, factor),
    )
    once.advance()
    changed.advance()
    for theta, other in zip(actors(once), actors(changed), strict=True):
        np.testing.assert_allclose(other, theta, rtol=0, atol=1e-4)
    assert critic_losses(changed) == pytest.approx(critic_losses(once), rel=1e-3)
