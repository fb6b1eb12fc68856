"""One update of SAC and its hybrid against the equations written plainly in torch, float64."""

import numpy as np
import pytest
import torch
from torch.distributions import Normal, TanhTransform

from algorithms.actor_critic.sac_update import Networks, Rates, Shapes, empty_report, update
from algorithms.matching.losses import matching_of
from algorithms.networks import network
from algorithms.networks.network import Shape
from algorithms.networks.optimizer import learned, learned_alone
from physics.randomness import generator
from tests.algorithms.plain import (
    GAMMA,
    ROWS,
    STORED,
    TAU,
    Plain,
    PlainBatch,
    Setting,
    assert_followed,
    assert_stepped,
    not_small,
    setting,
    squared,
)

RATE, SCALE = 3e-4, 2.5

RATES = Rates(np.float32(GAMMA), np.float32(TAU), np.float32(SCALE), RATE)


def shapes_in(where: Setting) -> Shapes:
    inputs, m = where.task.feature_size, where.task.action_size
    return Shapes(
        Shape(inputs, (16, 16), 2 * m), Shape(inputs, (16, 16), 1), Shape(inputs + m, (16, 16), 1)
    )


def networks_in(where: Setting, shapes: Shapes) -> Networks:
    """Random networks; the policy's sigmas lie below, within and above their bounds."""
    random, outputs = where.random, shapes.policy.outputs
    policy = not_small(shapes.policy, random)
    end = network.noisy_size(shapes.policy)
    policy[end - outputs // 2 : end] = np.resize([-0.5, -21.0, 2.5], outputs // 2)
    first, second = (learned_alone(not_small(shapes.critic, random)) for _ in range(2))
    value = learned(not_small(shapes.value, random))
    return Networks(
        learned_alone(policy),
        value._replace(target=not_small(shapes.value, random)),
        (first, second),
    )


@pytest.mark.parametrize("name", ["Pendulum", "RollingDie", "HalfCheetah"])
@pytest.mark.parametrize("weights", [(0.0, 0.0), (0.7, 0.0), (0.7, 0.3)])
def test_update_is_the_equations(name: str, weights: tuple[float, float]) -> None:
    where = setting(name)
    shapes, m = shapes_in(where), where.task.action_size
    networks = networks_in(where, shapes)
    random = generator(5, "rows")
    rows = random.integers(STORED, size=ROWS)
    noise = random.standard_normal((1, ROWS, m), np.float32)
    batch, e = PlainBatch(where, rows), torch.tensor(noise[0], dtype=torch.float64)

    policy = Plain(networks.policy.theta, shapes.policy)
    v, v_target = (
        Plain(theta, shapes.value) for theta in (networks.value.theta, networks.value.target)
    )
    q1, q2 = (Plain(learned.theta, shapes.critic) for learned in networks.critics)
    x = batch.normal(batch.f)
    out = policy(x)
    gaussian = Normal(out[:, :m], out[:, m:].clamp(-20, 2).exp())
    u = gaussian.mean + gaussian.stddev * e
    squash = TanhTransform().log_abs_det_jacobian(u, torch.tanh(u))  # type: ignore[no-untyped-call]
    log_pi = (gaussian.log_prob(u) - squash).sum(1)  # type: ignore[no-untyped-call]
    q1_new, q2_new = (q(torch.cat([x, torch.tanh(u)], 1))[:, 0] for q in (q1, q2))
    policy_loss = (log_pi - (batch.value_mean + batch.value_std * q1_new)).mean()
    aim = (torch.minimum(q1_new, q2_new) - log_pi / batch.value_std).detach()
    value_loss = ((v(x)[:, 0] - aim) ** 2).mean()
    targets = batch.targets(lambda x: v_target(x)[:, 0], SCALE)
    critic_losses = [batch.critic_loss(q, targets, weights, squared) for q in (q1, q2)]
    nets = [networks.policy, networks.value, *networks.critics]
    before = [net.theta.copy() for net in nets]
    followed = networks.value.target.copy()

    report = empty_report(1)
    done, lost = update(
        networks, 0, where.memory, rows[None], noise, where.coordinates, where.scaling,
        RATES, matching_of(weights, by_cosine=False), shapes, report,
    )  # fmt: skip

    assert (done, lost) == (1, -1)
    losses = [policy_loss, value_loss, *critic_losses]
    for net, old, loss, plain in zip(nets, before, losses, [policy, v, q1, q2], strict=True):
        assert_stepped(net, old, loss, plain, RATE)
    assert_followed(networks.value, followed)
    assert report.entropy[0] == pytest.approx(-log_pi.mean().item(), rel=1e-4)
    assert report.value_loss[0] == pytest.approx(value_loss.item(), rel=1e-4)
    both = report.critic_loss[0] + report.gradient_loss[0]
    assert both == pytest.approx(sum(loss.item() for loss in critic_losses) / 2, rel=1e-4)
