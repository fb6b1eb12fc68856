"""A snapshot's networks as functions of states: they act as the run does, slopes by differences."""

import numpy as np
import pytest

import physics
from algorithms.diagnostics.learned import LearnedCritic, LearnedPolicy, units
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policies, deterministic
from algorithms.networks.scaling import CLIP, Statistics, coordinates_of
from algorithms.snapshot import Critic, Inside, Snapshot
from physics.environment import Environment, FloatArray
from physics.randomness import generator

INSIDE = Inside((16, 16), "tanh")
BUMP = 1e-2
"""Of coordinates: networks are float32."""


def drawn(task: Environment) -> tuple[Snapshot, FloatArray]:
    """Networks that do something, on the scale of sampled states, and such states."""
    random = generator(0, "learned test")
    states, _ = task.sample(random, 40)
    statistics = Statistics(coordinates_of(task), task.action_size)
    statistics.observe(task.features(states).astype(np.float32))
    scaling = statistics.scaling()
    shapes = [
        INSIDE.shape(task.feature_size, task.action_size),
        INSIDE.shape(task.feature_size + task.action_size, 1),
    ]
    thetas = [initial_theta(shape, random) for shape in shapes]
    thetas = [t + np.float32(0.1) * random.standard_normal(t.size, np.float32) for t in thetas]
    policy = deterministic(thetas[0], scaling.mean, scaling.inverse, task.action_size)
    critic = Critic(thetas[1], -3.0, 7.0)
    return Snapshot(0, task.action_size, INSIDE, policy, critic), states


@pytest.mark.parametrize("name", ["Pendulum", "HalfCheetah"])
def test_the_policy_acts_as_the_run_does(name: str) -> None:
    task = physics.make(name)
    snapshot, states = drawn(task)
    shape = INSIDE.shape(task.feature_size, task.action_size)
    own = Policies([snapshot.policy] * len(states), shape).act(task.features(states))
    actions, _ = LearnedPolicy(task, snapshot)(states)
    np.testing.assert_allclose(actions, own, atol=2e-6)
    assert np.abs(own).max() > 0.1


@pytest.mark.parametrize("name", ["Pendulum", "HalfCheetah"])
def test_slopes_are_those_of_differences(name: str) -> None:
    task = physics.make(name)
    snapshot, states = drawn(task)
    assert snapshot.critic is not None
    policy, critic = LearnedPolicy(task, snapshot), LearnedCritic(task, snapshot, snapshot.critic)
    unit = units(task, snapshot)
    along = BUMP * unit * generator(1, "direction").standard_normal(states.shape)
    actions, jacobian = policy(states)
    ahead, behind = policy(states + along)[0], policy(states - along)[0]
    by_state = np.einsum("bmn,bn->bm", jacobian, along)
    np.testing.assert_allclose(by_state, (ahead - behind) / 2, atol=0.02 * BUMP)

    def values(way: float, part: FloatArray) -> FloatArray:
        return snapshot.values(task.features(states + way * along), actions + way * part)

    turn = np.full_like(actions, BUMP)
    gradient = critic(states, actions)
    change = (gradient.by_state * along).sum(axis=1) + (gradient.by_action * turn).sum(axis=1)
    difference = (values(1.0, turn) - values(-1.0, turn)) / 2
    np.testing.assert_allclose(change, difference, atol=0.02 * BUMP * 7.0)
    assert np.abs(change).max() > BUMP


def test_what_no_network_sees_has_no_unit_and_no_slope() -> None:
    task = physics.make("HalfCheetah")
    snapshot, states = drawn(task)
    unit = units(task, snapshot)
    assert set(np.flatnonzero(unit == 0)) == set(task.hidden) != set()
    _, jacobian = LearnedPolicy(task, snapshot)(states)
    assert not jacobian[:, :, list(task.hidden)].any()


def test_a_clipped_feature_has_no_slope() -> None:
    task = physics.make("MassPoint")
    snapshot, _ = drawn(task)
    policy = snapshot.policy
    edge = float(policy.mean[0] + CLIP / policy.inverse[0])
    _, jacobian = LearnedPolicy(task, snapshot)(np.array([[0.99 * edge], [1.01 * edge]]))
    assert jacobian[0, 0, 0] != 0.0
    assert jacobian[1, 0, 0] == 0.0
