"""The trainer: what it yields, when it stops, and the policies that it gives."""

from typing import Any

import numpy as np
import pytest

import algorithms
import physics
from algorithms.actor_critic.agent import Agent
from algorithms.early_end import DivergedError, NotFiniteQuantityError
from algorithms.experience.rollout import start_states
from algorithms.measurement import Measurement

TIMESTEPS = 1_600
ON_POLICY = {"environments": 4, "window": 20}


def points(measured: list[Measurement]) -> list[tuple[int, int, float]]:
    return [(m.seed, m.timestep, m.return_mean) for m in measured]


def test_it_yields_what_it_keeps_and_goes_on_where_a_loop_was_left() -> None:
    whole = algorithms.Trainer("ddpg", "Pendulum", [0, 1], timesteps=TIMESTEPS)
    assert points(whole.run()) == points(whole.measurements)
    assert [m.timestep for m in whole.measurements] == [800, 800, 1600, 1600]
    parted = algorithms.train("ddpg", "Pendulum", [0, 1], timesteps=TIMESTEPS)
    next(parted)
    assert len(parted.measurements) == 1
    assert points(parted.run()) == points(whole.measurements)


def test_its_policy_earns_what_was_measured_last() -> None:
    trainer = algorithms.Trainer("ddpg", "Pendulum", [3], timesteps=TIMESTEPS)
    last = trainer.run()[-1]
    policy, pendulum = trainer.policy(), physics.make("Pendulum")
    starts, _ = start_states(pendulum, [(3, "evaluation", 2)])
    state, earned = starts, 0.0
    for _ in range(pendulum.horizon):
        state, reward, _ = pendulum.step(state, policy.act_in(state).astype(np.float64))
        earned += float(reward[0])
    assert earned == pytest.approx(last.return_mean, rel=1e-3)
    assert policy.header.origin["seed"] == 3
    assert policy.header.origin["algorithm"] == "ddpg"
    assert policy.header.origin["config"]["batch_size"] == 64
    assert policy.header.origin["timestep"] == TIMESTEPS


@pytest.mark.parametrize(
    ("name", "config"), [("ddpg", {}), ("ppo", ON_POLICY), ("gd", {}), ("mpc", {"horizon": 5})]
)
def test_a_callback_stops_its_run_alone(name: str, config: dict[str, int]) -> None:
    seen: list[Measurement] = []

    def stop_the_second(measurement: Measurement) -> bool:
        seen.append(measurement)
        return measurement.seed == 1

    trainer = algorithms.Trainer(name, "Pendulum", [0, 1], None, TIMESTEPS, config, stop_the_second)
    assert trainer.run() == seen
    assert [m.timestep for m in seen if m.seed == 1] == [800]
    alone = algorithms.Trainer(name, "Pendulum", [0], None, TIMESTEPS, config).run()
    assert points([m for m in seen if m.seed == 0]) == points(alone)
    if name != "mpc":
        assert trainer.policy(1).header.origin["timestep"] >= 800
        assert trainer.policy(0).header.origin["timestep"] >= TIMESTEPS
    with pytest.raises(StopIteration):
        next(trainer)


def test_when_all_have_stopped_it_ends_and_their_policies_stay() -> None:
    trainer = algorithms.Trainer(
        "ddpg", "Pendulum", range(3), timesteps=80_000, callback=lambda m: m.timestep >= 800
    )
    assert [(m.seed, m.timestep) for m in trainer.run()] == [(0, 800), (1, 800), (2, 800)]
    actions = [trainer.policy(seed).act([1.0, 0.0, 0.5]) for seed in range(3)]
    assert len({float(action[0]) for action in actions}) == 3


def test_the_policy_of_a_run_that_is_not_there_is_refused() -> None:
    trainer = algorithms.Trainer("ddpg", "Pendulum", [0, 1], timesteps=TIMESTEPS)
    for seed in (None, 7):
        with pytest.raises(ValueError, match=rf"seed must be one of \[0, 1\], not {seed}"):
            trainer.policy(seed)
    with pytest.raises(ValueError, match="mpc learns no policy"):
        algorithms.Trainer("mpc", "Pendulum", [0], config={"horizon": 5}).policy()


def test_a_run_that_diverged_has_none_and_the_others_have(monkeypatch: pytest.MonkeyPatch) -> None:
    trainer = algorithms.Trainer("ddpg", "Pendulum", [0, 1], timesteps=TIMESTEPS)
    next(trainer)
    learn = Agent.learn

    def diverging(agent: Agent) -> None:
        if agent.seed == 0:
            raise NotFiniteQuantityError("critic loss")
        learn(agent)

    monkeypatch.setattr(Agent, "learn", diverging)
    with pytest.raises(DivergedError, match="seed 0 diverged"):
        trainer.run()
    with pytest.raises(ValueError, match="no policy of seed 0: diverged"):
        trainer.policy(0)
    assert trainer.policy(1).header.origin["timestep"] == TIMESTEPS


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"algorithm": "dppg"}, "did you mean 'ddpg'"),
        ({"seeds": 3}, "seeds must be different integers from 0 on, not 3"),
        ({"weights": 1.0}, "weights must be two numbers, .* not 1.0"),
        ({"config": {"hiden_units": 8}}, "ddpg: there is no setting 'hiden_units'; did you mean"),
        ({"config": {"gamma": 2.0, "tau": "?"}}, "ddpg: tau: .*, not '\\?'; gamma: .*, not 2.0"),
    ],
)
def test_a_wrong_argument_is_refused_before_anything_is_trained(
    wrong: dict[str, Any], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        algorithms.train(**{"algorithm": "ddpg", "environment": "Pendulum", "seeds": [0], **wrong})
