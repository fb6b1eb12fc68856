"""An update of SHAC against the equations in torch, through `physics.torch_step`."""

import numpy as np
import pytest
import torch

import physics
from algorithms.ascent.shac import BETAS, SHAC, build
from algorithms.settings import SHACConfig
from tests.algorithms.on_policy import lived as plainly
from tests.algorithms.on_policy.lived import GAMMA, SMALL, Lived, lived
from tests.algorithms.plain import Plain, adam_step

ENVIRONMENTS, STEPS, RATE = 4, 8, 1e-3
CONFIG = SHACConfig(
    environments=ENVIRONMENTS, window=STEPS, actor_rate=RATE, critic_rate=RATE, critic_epochs=1,
    critic_batches=1, target_share=0.25, **SMALL,
)  # fmt: skip


def objective(where: Lived, pi: Plain, log_sigma: torch.Tensor, follower: Plain) -> torch.Tensor:
    """J in the unit of values, the steps lived again: the same actions, differentiated."""
    task, scaling, window = where.task, where.moment.scaling, where.window
    e = torch.tensor(window.noise, dtype=torch.float64) / log_sigma.detach().exp()
    began, taken = torch.tensor(where.states), torch.tensor(where.actions)
    total, state, age = torch.zeros(1, dtype=torch.float64), began[0], np.zeros(ENVIRONMENTS)
    for t in range(STEPS):
        begins = torch.tensor(window.is_last[t - 1] if t else np.ones(ENVIRONMENTS, bool))
        state = torch.where(begins[:, None], began[t], state)
        np.testing.assert_allclose(state.detach(), began[t], rtol=1e-9, atol=1e-9)
        mean = pi(plainly.normal(task.features(state), scaling))
        own = torch.tanh(mean + log_sigma.exp() * e[t])
        np.testing.assert_allclose(own.detach(), taken[t], rtol=0, atol=1e-5)
        state, reward = plainly.step(task, state, taken[t] + own - own.detach())
        worth = plainly.value(follower, task.features(state), scaling)
        worth = torch.where(torch.tensor(window.terminated[t]), 0.0, worth)
        ending = torch.tensor(window.is_last[t])
        total = total + (torch.tensor(GAMMA**age) * reward).sum()
        total = total + (torch.tensor(GAMMA ** (age + 1)) * worth)[ending].sum()
        age = np.where(window.is_last[t], 0, age + 1)
    return total.sum() / ENVIRONMENTS / float(scaling.value_std)


@pytest.mark.parametrize("name", ["Pendulum", "CartPole", "RollingDie"])
def test_update_is_the_equations(name: str) -> None:
    task = physics.make(name)
    where = lived(name, build(task, [3], (0.0, 0.0), 10**6, CONFIG))
    window, networks, scaling = where.window, where.run.networks, where.moment.scaling
    assert window.is_last[:-1].any()
    assert window.terminated[:-1].any() == (name == "CartPole")
    assert not window.is_last[:-1].all(axis=0).any()
    theta, v_theta, target = (
        part.copy()
        for part in (networks.actor.theta, networks.critic.theta, networks.critic.target)
    )
    pi, log_sigma = plainly.actor(theta, networks.actor_shape)
    follower, v = Plain(target, networks.critic_shape), Plain(v_theta, networks.critic_shape)
    J = objective(where, pi, log_sigma, follower)
    gradients = torch.autograd.grad(-J, (pi.theta, log_sigma))
    next_values = plainly.value(follower, torch.tensor(window.next_features), scaling).detach()
    returns = torch.tensor(plainly.lambda_returns(window, next_values.numpy()))
    own = plainly.value(v, torch.tensor(window.features), scaling)
    loss = (((own - returns) / float(scaling.value_std)) ** 2).mean()
    (critic_gradient,) = torch.autograd.grad(loss, v.theta)

    shac = SHAC(task, CONFIG)
    outlook = shac.look_ahead(networks, window, scaling)
    report = shac.learn(networks, window, outlook, where.moment)

    assert report.lost == ""
    expected = torch.cat(gradients).numpy()
    for net, before, wanted in (
        (networks.actor, theta, expected),
        (networks.critic, v_theta, critic_gradient.numpy()),
    ):
        ours, scale = net.m / np.float32(0.3), np.abs(wanted).max()
        np.testing.assert_allclose(ours / scale, wanted / scale, rtol=2e-3, atol=2e-5)
        stepped = adam_step(before, ours, RATE, BETAS)
        np.testing.assert_allclose(net.theta, stepped, rtol=0, atol=1e-3 * RATE)
    followed = 0.25 * target + 0.75 * networks.critic.theta
    np.testing.assert_allclose(networks.critic.target, followed, rtol=1e-5, atol=1e-7)
    assert report.means.critic_loss == pytest.approx(loss.item(), rel=1e-4)
    assert report.means.actor_gradient_norm == pytest.approx(np.linalg.norm(expected), rel=1e-3)
    assert report.means.v_mean == pytest.approx(next_values.mean().item(), rel=1e-4)
