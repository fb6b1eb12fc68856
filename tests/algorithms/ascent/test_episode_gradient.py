"""The written-out gradient of whole episodes against torch autograd through `physics.torch_step`.

torch lives the same episodes again, in float64: each action is the one that was taken, its gradient
that of the network at the state torch has reached.
"""

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

import physics
from algorithms.ascent.episode_gradient import live, return_gradient
from algorithms.networks import network
from algorithms.networks.network import Shape
from algorithms.networks.policy import Policies, Policy, deterministic
from algorithms.networks.scaling import CLIP, Statistics, coordinates_of
from physics.environment import Environment, FloatArray
from physics.randomness import generator
from tests.algorithms.plain import Plain

UNITS, EPISODES = 16, 2


def setting(task: Environment, seed: int) -> tuple[Policy, Shape, FloatArray]:
    """An actor that does something, with features on a scale of their own, and start states."""
    random = generator(seed, "gradient test")
    shape = Shape(task.feature_size, (UNITS,) * 2, task.action_size)
    theta = network.initial(shape, random)
    theta += np.float32(0.1) * random.standard_normal(theta.size, np.float32)
    statistics = Statistics(coordinates_of(task), task.action_size)
    states, _ = task.sample(random, 50)
    statistics.observe(task.features(states).astype(np.float32))
    scaling = statistics.scaling()
    starts = task.initial_states(range(seed, seed + EPISODES))
    policy = deterministic(theta, scaling.mean, scaling.inverse, task.action_size)
    return policy, shape, starts


def torch_gradient(
    task: Environment, policy: Policy, shape: Shape, start: FloatArray
) -> tuple[float, NDArray[np.float64]]:
    """The return of one episode and its gradient."""
    plain, act = Plain(policy.theta, shape), Policies([policy], shape).act
    mean, inverse = (torch.from_numpy(part.astype(np.float64)) for part in policy[1:3])
    state, total = torch.from_numpy(start[None]), torch.zeros(1, dtype=torch.float64)
    for _ in range(task.horizon):
        features = task.features(state)
        own = torch.tanh(plain(torch.clip((features - mean) * inverse, -float(CLIP), float(CLIP))))
        taken = torch.from_numpy(act(task.features(state.detach().numpy())))
        step = physics.torch_step(task, state, taken + own - own.detach())
        state, total = step.next_state, total + step.reward
        if step.terminated.item():
            break
    total.sum().backward()  # type: ignore[no-untyped-call]
    assert plain.theta.grad is not None
    return total.item(), plain.theta.grad.numpy()


@pytest.mark.parametrize(
    "name",
    [
        "Pendulum",
        "RollingDie",
        "HalfCheetah",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("MassPoint", "CartPole", "CartPoleSwingUp", "MountainCar")
        ),
    ],
)
def test_it_is_the_gradient_of_torch_through_whole_episodes(name: str) -> None:
    task = physics.make(name)
    settings = [setting(task, seed) for seed in (1, 5)]
    shape = settings[0][1]
    policies = [policy for policy, *_ in settings]
    episodes, failures = live(task, policies, shape, np.stack([starts for *_, starts in settings]))
    assert episodes is not None
    assert not failures
    for k, (policy, _, starts) in enumerate(settings):
        gradient = np.empty_like(policy.theta)
        return_gradient(
            *(policy.theta, shape, policy.mean, policy.inverse, task.feature_sources),
            episodes.of(k),
            gradient,
        )
        alone = [torch_gradient(task, policy, shape, start) for start in starts]
        for e, (total, _) in enumerate(alone):
            assert episodes.rewards[:, k, e].sum() == pytest.approx(total, rel=1e-9)
        expected = np.mean([one for _, one in alone], axis=0)
        error = np.linalg.norm(gradient - expected) / np.linalg.norm(expected)
        assert error < 1e-5
