"""Updates of PPO against the equations written plainly in torch."""

from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

import physics
from algorithms.policy_gradient.ppo import PPO, build
from algorithms.settings import PPOConfig
from tests.algorithms.on_policy import lived as plainly
from tests.algorithms.on_policy.lived import SMALL, Lived, lived
from tests.algorithms.plain import Plain, adam_step

RATE, BOUND = 0.02, 0.2


def config(epochs: int) -> PPOConfig:
    """Whole windows as batches, so that their order means nothing."""
    return PPOConfig(
        environments=4, window=8, rate=RATE, epochs=epochs, batches=1, ratio_bound=BOUND, **SMALL
    )


def loss_of(
    theta: Tensor, old: Tensor, x: Tensor, noise: Tensor, A: Tensor, where: Lived
) -> Tensor:
    """L at parameters `theta`, of actions drawn with the `old`."""
    shape = where.run.networks.actor_shape

    def at(parameters: Tensor) -> tuple[Tensor, Tensor]:
        plain = Plain(np.zeros(len(parameters) - shape.outputs, np.float32), shape)
        plain.theta = parameters[: -shape.outputs]
        return plain(x), parameters[-shape.outputs :].exp()

    u = at(old)[0] + noise
    normal: Any = torch.distributions.Normal  # its methods are not typed
    before, now = (normal(*at(each)).log_prob(u).sum(1) for each in (old, theta))
    ratio = (now - before).exp()
    advantage = (A - A.mean()) / A.std(correction=0)
    return -torch.minimum(ratio * advantage, ratio.clamp(1 - BOUND, 1 + BOUND) * advantage).mean()


@pytest.mark.parametrize("name", ["Pendulum", "CartPole", "RollingDie"])
def test_update_is_the_equations(name: str) -> None:
    """Two epochs: in the first no ratio differs from 1, in the second some are clipped."""
    task = physics.make(name)
    moments, thetas = [], []
    for epochs in (1, 2):
        where = lived(name, build(task, [3], (0.0, 0.0), 10**6, config(epochs)))
        networks, scaling, window = where.run.networks, where.moment.scaling, where.window
        old, v_theta = networks.actor.theta.copy(), networks.critic.theta.copy()
        ppo = PPO(config(epochs))
        outlook = ppo.look_ahead(networks, window, scaling)
        report = ppo.learn(networks, window, outlook, where.moment)
        assert report.lost == ""
        moments.append(networks.actor.m.copy())
        thetas.append(networks.actor.theta.copy())
        if epochs == 1:
            first_critic, first_report = networks.critic, report
    assert window.is_last[:-1].any()
    assert window.terminated[:-1].any() == (name == "CartPole")
    v = Plain(v_theta, networks.critic_shape)
    features = torch.tensor(window.features)
    own = plainly.value(v, features, scaling)
    next_values = plainly.value(v, torch.tensor(window.next_features), scaling).detach()
    returns = torch.tensor(plainly.lambda_returns(window, next_values.numpy()))
    loss = (((own - returns) / float(scaling.value_std)) ** 2).mean()
    (critic_gradient,) = torch.autograd.grad(loss, v.theta)
    A = (returns - own.detach()).ravel()
    x = plainly.normal(features, scaling).reshape(A.numel(), -1)
    noise = torch.tensor(window.noise, dtype=torch.float64).reshape(A.numel(), -1)
    start = torch.tensor(old, dtype=torch.float64)
    ours = [moments[0] / np.float32(0.1), (moments[1] - np.float32(0.9) * moments[0]) / 0.1]
    for gradient, at in zip(ours, (old, thetas[0]), strict=True):
        theta = torch.tensor(at, dtype=torch.float64, requires_grad=True)
        (expected,) = torch.autograd.grad(loss_of(theta, start, x, noise, A, where), theta)
        scale = float(expected.abs().max())
        np.testing.assert_allclose(gradient / scale, expected / scale, rtol=5e-3, atol=5e-5)
    np.testing.assert_allclose(thetas[0], adam_step(old, ours[0], RATE), rtol=0, atol=1e-3 * RATE)
    critic, wanted = first_critic.m / np.float32(0.1), critic_gradient.numpy()
    scale = np.abs(wanted).max()
    np.testing.assert_allclose(critic / scale, wanted / scale, rtol=2e-3, atol=2e-5)
    assert first_report.means.critic_loss == pytest.approx(loss.item(), rel=1e-4)
    assert first_report.means.clipped == 0.0
    assert 0.0 < report.means.clipped < 0.5
    assert report.means.policy_distance > 0.001
