"""Learners that have learned a little, and their policies."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import algorithms
import physics
from algorithms.acting.policy import TrainedPolicy, policy_of
from algorithms.learner import Learner
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policies, Policy, deterministic
from algorithms.networks.shape import Shape
from algorithms.snapshot import Snapshot, inside
from physics.environment import Environment

SMALL: dict[str, dict[str, Any]] = {
    "ddpg": {},
    "td3": {},
    "sac": {},
    "gd": {},
    "ppo": {"environments": 4, "window": 20},
    "shac": {"environments": 4, "window": 20},
}


def learner_of(name: str, environment: str, config: dict[str, Any] | None = None) -> Learner:
    """A learner after one call of `advance`."""
    chosen = {**SMALL[name], **(config or {})}
    learner = algorithms.build(name, environment, [0], timesteps=1_600, config=chosen)
    learner.advance()
    return learner


def policy_by(learner: Learner, environment: str, **origin: Any) -> TrainedPolicy:
    """Its policy."""
    snapshot = learner.snapshot(0)
    assert snapshot is not None
    return policy_of(snapshot, physics.make(environment), origin)


def evaluated(learner: Any, features: NDArray[np.float64]) -> NDArray[np.float64]:
    """The actions [b, m] of the learner's own evaluation, for features [b, F]."""
    runs: Any = learner._agents if hasattr(learner, "_agents") else learner._runs
    policy: Policy = runs[0].policy()
    shape: Shape = learner._shape
    policies = Policies([policy], shape)
    return np.concatenate([policies.act(row[None]) for row in features])


def untrained(task: Environment) -> Snapshot:
    """A snapshot of a task's size."""
    shape = Shape(task.feature_size, (8,), task.action_size)
    mean = np.zeros(task.feature_size, np.float32)
    theta = initial_theta(shape, np.random.default_rng(0))
    policy = deterministic(theta, mean, np.ones_like(mean), task.action_size)
    return Snapshot(0, task.action_size, inside(shape), policy)
