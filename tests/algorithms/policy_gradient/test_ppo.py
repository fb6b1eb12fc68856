"""PPO learns, needs no derivatives, and tells how far it moved."""

import numpy as np

import algorithms
from algorithms.measurement import Measurement
from algorithms.policy_gradient.ppo import build
from algorithms.settings import PPOConfig
from physics.environment import FloatArray, Linearization
from tests.algorithms.other_rewards import OtherRewards


def test_it_learns_to_balance_a_pole() -> None:
    config = {"rate": 1e-3, "environments": 4, "window": 128}
    measured = algorithms.train("ppo", "CartPole", [0], None, 16_000, config)
    curve = [m.return_mean for m in measured]
    assert np.mean(curve[-5:]) > 190.0


class StepsAlone(OtherRewards):
    """Pendulum, whose derivatives nobody may ask for."""

    def __init__(self) -> None:
        super().__init__("Pendulum", lambda s, r: r)

    def differentiate(self, states: FloatArray, actions: FloatArray) -> Linearization:
        raise NotImplementedError("these are not known")


def test_it_asks_for_no_derivatives_and_stays_near_the_policy_it_had() -> None:
    config = PPOConfig(environments=4, window=50, hidden_units=8)
    learner = build(StepsAlone(), [0, 1], (0.0, 0.0), 2_400, config)
    measured: list[Measurement] = []
    while not learner.finished:
        for event in learner.advance():
            assert isinstance(event, Measurement)
            measured.append(event)
    assert {m.jacobians for m in measured} == {0}
    seen = [m.diagnostics for m in measured]
    assert all(0.0 < d["policy_distance"] < 0.1 for d in seen)
    assert all(0.0 <= d["clipped"] < 0.6 for d in seen)
