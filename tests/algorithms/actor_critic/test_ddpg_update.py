"""One update of DDPG and its hybrids against the equations written plainly in torch, float64."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor

from algorithms.actor_critic.ddpg_update import Rates, empty_report, update
from algorithms.matching.losses import matching_of
from algorithms.networks import network
from algorithms.networks.activation import ELU, Activation, ReLU, SiLU, Tanh
from algorithms.networks.network import Shape
from algorithms.networks.optimizer import learned
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

DECAY, ACTOR_RATE, CRITIC_RATE = 1e-2, 1e-4, 1e-3


def angular(own: Tensor, target: Tensor) -> Tensor:
    """Equation 3, both vectors made longer by one more entry, which the product leaves out."""
    own_norm, target_norm = (((each**2).sum(1) + 1e-6).sqrt() for each in (own, target))
    return 1 - (own * target).sum(1) / (own_norm * target_norm)


def shapes_in(
    where: Setting, hidden: tuple[int, ...], activation: Activation
) -> tuple[Shape, Shape]:
    inputs, m = where.task.feature_size, where.task.action_size
    return Shape(inputs, hidden, m, activation), Shape(inputs + m, hidden, 1, activation)


@pytest.mark.parametrize("name", ["Pendulum", "CartPole", "RollingDie"])
@pytest.mark.parametrize(
    ("weights", "distance"),
    [
        ((0.0, 0.0), squared),
        ((0.7, 0.0), squared),
        ((0.0, 0.3), squared),
        ((0.7, 0.3), squared),
        ((0.7, 0.0), angular),
        ((0.7, 0.3), angular),
    ],
)
def test_update_is_the_equations(
    name: str, weights: tuple[float, float], distance: Callable[[Tensor, Tensor], Tensor]
) -> None:
    assert_update_is_the_equations(name, weights, distance, (16, 16), Tanh())


@pytest.mark.parametrize(
    ("hidden", "activation"),
    [
        ((16,), Tanh()),
        ((20, 12, 8), Tanh()),
        ((12, 20), ELU()),
        ((20, 12, 8), SiLU()),
        ((16, 8), ReLU()),
    ],
)
def test_update_is_the_equations_for_any_network(
    hidden: tuple[int, ...], activation: Activation
) -> None:
    assert_update_is_the_equations("Pendulum", (0.7, 0.3), squared, hidden, activation)


def assert_update_is_the_equations(
    name: str,
    weights: tuple[float, float],
    distance: Callable[[Tensor, Tensor], Tensor],
    hidden: tuple[int, ...],
    activation: Activation,
) -> None:
    where = setting(name)
    shapes = shapes_in(where, hidden, activation)
    actor, critic = (
        learned(not_small(shape, where.random))._replace(target=not_small(shape, where.random))
        for shape in shapes
    )
    rows = generator(5, "rows").integers(STORED, size=ROWS)
    batch = PlainBatch(where, rows)
    pi, pi_target = (Plain(theta, shapes[0]) for theta in (actor.theta, actor.target))
    q, q_target = (Plain(theta, shapes[1]) for theta in (critic.theta, critic.target))
    targets = batch.targets(lambda x: q_target(torch.cat([x, torch.tanh(pi_target(x))], 1))[:, 0])
    decayed = q.theta[: network.decayed_size(shapes[1])]
    critic_loss = batch.critic_loss(q, targets, weights, distance) + DECAY / 2 * (decayed**2).sum()
    x = batch.normal(batch.f)
    actor_loss = -q(torch.cat([x, torch.tanh(pi(x))], 1)).mean()
    before = [part.copy() for part in (actor.theta, actor.target, critic.theta, critic.target)]

    rates = Rates(np.float32(GAMMA), np.float32(TAU), ACTOR_RATE, CRITIC_RATE, np.float32(DECAY))
    done, lost = update(
        actor, critic, 0, where.memory, rows[None], where.coordinates, where.scaling, rates,
        matching_of(weights, by_cosine=distance is angular), shapes, empty_report(1),
    )  # fmt: skip

    assert (done, lost) == (1, -1)
    assert_stepped(actor, before[0], actor_loss, pi, ACTOR_RATE)
    assert_stepped(critic, before[2], critic_loss, q, CRITIC_RATE)
    assert_followed(actor, before[1])
    assert_followed(critic, before[3])
