"""Updates of TD3 and its hybrid against the equations written plainly in torch, float64."""

import numpy as np
import pytest
import torch
from torch import Tensor

from algorithms.actor_critic.deterministic import empty_report
from algorithms.actor_critic.td3_update import Networks, Rates, update
from algorithms.matching.losses import ROBUST, matching_of
from algorithms.networks.optimizer import learned
from algorithms.networks.shape import Shape
from physics.randomness import generator
from tests.algorithms.plain import (
    GAMMA,
    ROWS,
    STORED,
    TAU,
    Plain,
    PlainBatch,
    assert_followed,
    assert_stepped,
    not_small,
    robust,
    setting,
)

ACTOR_RATE, CRITIC_RATE, NOISE, BOUND = 1e-4, 1e-3, 0.4, 0.5
RATES = Rates(
    np.float32(GAMMA), np.float32(TAU), ACTOR_RATE, CRITIC_RATE, np.float32(NOISE),
    np.float32(BOUND), 2,
)  # fmt: skip


@pytest.mark.parametrize("name", ["Pendulum", "RollingDie"])
@pytest.mark.parametrize("weights", [(0.0, 0.0), (0.7, 0.0), (0.7, 0.3)])
@pytest.mark.parametrize("done", [0, 1])
def test_update_is_the_equations(name: str, weights: tuple[float, float], done: int) -> None:
    where = setting(name)
    inputs, m = where.task.feature_size, where.task.action_size
    shapes = Shape(inputs, (16, 16), m), Shape(inputs + m, (16, 16), 1)
    actor, first, second = (
        learned(not_small(shape, where.random))._replace(target=not_small(shape, where.random))
        for shape in (shapes[0], shapes[1], shapes[1])
    )
    random = generator(5, "rows")
    rows = random.integers(STORED, size=ROWS)
    noise = random.standard_normal((1, ROWS, m), np.float32)
    batch, e = PlainBatch(where, rows), torch.tensor(noise[0], dtype=torch.float64)
    pi_target = Plain(actor.target, shapes[0])
    q1, q2 = (Plain(critic.theta, shapes[1]) for critic in (first, second))
    targets_of = [Plain(critic.target, shapes[1]) for critic in (first, second)]

    def following(x: Tensor) -> Tensor:
        smoothed = torch.tanh(pi_target(x)) + (NOISE * e).clamp(-BOUND, BOUND)
        joined = torch.cat([x, smoothed.clamp(-1, 1)], 1)
        return torch.minimum(*(q(joined)[:, 0] for q in targets_of))

    targets = batch.targets(following)
    critic_losses = [
        batch.critic_loss(q, targets, weights, *robust(batch.goes_on)) for q in (q1, q2)
    ]
    networks = [actor, first, second]
    before = [net.theta.copy() for net in networks]
    followed = [net.target.copy() for net in networks]

    report = empty_report(1)
    told = update(
        Networks(actor, (first, second)), done, where.memory, rows[None], noise,
        where.coordinates, where.scaling, RATES, matching_of(weights, ROBUST), shapes, report,
    )  # fmt: skip

    assert told == (1, -1)
    if done == 0:
        for net, old, loss, plain in zip(
            networks[1:], before[1:], critic_losses, (q1, q2), strict=True
        ):
            assert_stepped(net, old, loss, plain, CRITIC_RATE)
        for net, old, target in zip(networks, before, followed, strict=True):
            np.testing.assert_array_equal(net.target, target)
            assert (net is actor) == np.array_equal(net.theta, old)
    else:
        pi, q1_new = Plain(before[0], shapes[0]), Plain(first.theta, shapes[1])
        x = batch.normal(batch.f)
        actor_loss = -q1_new(torch.cat([x, torch.tanh(pi(x))], 1)).mean()
        assert_stepped(actor, before[0], actor_loss, pi, ACTOR_RATE)
        for net, target in zip(networks, followed, strict=True):
            assert_followed(net, target)
    both = report.critic_loss[0] + report.gradient_loss[0]
    assert both == pytest.approx(sum(loss.item() for loss in critic_losses) / 2, rel=1e-4)
