"""An episode: the policy's actions, the task's steps, and the return that evaluation finds."""

import numpy as np
import pytest

import algorithms
import physics
from algorithms.experience.evaluation import episode_returns
from algorithms.snapshot import Snapshot
from physics.environment import Environment
from workers.policies.episode import Episode, play


def learnt(environment: Environment) -> Snapshot:
    learner = algorithms.build("ddpg", environment, [0], timesteps=1_600, config={})
    learner.advance()
    snapshot = learner.snapshot(0)
    assert snapshot is not None
    return snapshot


@pytest.fixture(params=["Pendulum", "CartPole"])
def environment(request: pytest.FixtureRequest) -> Environment:
    return physics.make(request.param)


def test_every_step_follows_from_the_one_before(environment: Environment) -> None:
    policies = learnt(environment).policies()
    start = environment.initial_states([3])[0]
    episode = play(environment, policies, start)
    steps = len(episode.actions)
    assert episode.states.shape == (steps + 1, environment.state_size)
    np.testing.assert_array_equal(episode.states[0], start)
    transition = environment.step(episode.states[:-1], episode.actions)
    np.testing.assert_array_equal(transition.next_state, episode.states[1:])
    np.testing.assert_array_equal(transition.reward, episode.rewards)
    assert not transition.terminated[:-1].any()
    assert episode.terminated == transition.terminated[-1]
    assert episode.terminated or steps == environment.horizon


def test_its_return_is_that_of_evaluation(environment: Environment) -> None:
    policies = learnt(environment).policies()
    starts = environment.initial_states([5])
    episode: Episode = play(environment, policies, starts[0])
    (expected,), _ = episode_returns(environment, policies, starts)
    assert episode.rewards.sum() == pytest.approx(expected, rel=1e-12)


def test_a_start_outside_the_domain_is_refused() -> None:
    pendulum = physics.make("Pendulum")
    with pytest.raises(ValueError, match="finite"):
        play(pendulum, learnt(pendulum).policies(), np.array([np.nan, 0.0]))
