"""A snapshot acts as its run's policy does, and shows its critic."""

import numpy as np
import pytest

import algorithms
import physics
from algorithms.actor_critic.learner import OffPolicyLearner
from algorithms.learner import Learner
from algorithms.networks.policy import Policies
from algorithms.snapshot import Snapshot, snapshot_of


def trained() -> tuple[Learner, Snapshot]:
    learner = algorithms.build("ddpg", "Pendulum", [0], timesteps=1_600, config={})
    learner.advance()
    snapshot = learner.snapshot(0)
    assert snapshot is not None
    return learner, snapshot


def test_acts_as_the_run_does_also_after_a_trip_through_arrays() -> None:
    learner, snapshot = trained()
    assert isinstance(learner, OffPolicyLearner)
    states = physics.make("Pendulum").initial_states([7])
    features = physics.make("Pendulum").features(states)
    own = Policies([learner._agents[0].policy()], learner._shape).act(features)
    again = snapshot_of(snapshot.arrays())
    assert again.timestep == 100
    np.testing.assert_array_equal(again.policies().act(features), own, strict=True)


def test_values_are_in_the_units_of_the_task() -> None:
    _, snapshot = trained()
    assert snapshot.critic is not None
    environment = physics.make("Pendulum")
    features = environment.features(environment.initial_states(range(5)))
    values = snapshot.values(features, np.zeros((5, 1)))
    unit = snapshot._replace(critic=snapshot.critic._replace(value_mean=0.0, value_std=1.0))
    raw = unit.values(features, np.zeros((5, 1)))
    critic = snapshot.critic
    np.testing.assert_allclose(values, critic.value_mean + critic.value_std * raw, rtol=1e-12)
    assert np.ptp(raw) > 0


def test_without_a_critic_there_are_no_values() -> None:
    _, snapshot = trained()
    bare = snapshot_of(snapshot._replace(critic=None).arrays())
    with pytest.raises(ValueError, match="learns no critic"):
        bare.values(np.zeros((1, 3)), np.zeros((1, 1)))
