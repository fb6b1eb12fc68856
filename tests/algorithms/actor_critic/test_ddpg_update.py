"""One update of DDPG and its hybrids against the equations written plainly in torch, float64."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch

from algorithms.actor_critic.ddpg_update import Rates, update
from algorithms.actor_critic.deterministic import empty_report
from algorithms.matching.losses import COSINE, L2, ROBUST, matching_of
from algorithms.networks.activation import ELU, Activation, ReLU, SiLU, Tanh
from algorithms.networks.optimizer import learned
from algorithms.networks.shape import Shape, decayed_size
from physics.randomness import generator
from tests.algorithms.plain import (
    GAMMA,
    ROWS,
    STORED,
    TAU,
    Plain,
    PlainBatch,
    Setting,
    angular,
    assert_followed,
    assert_stepped,
    not_small,
    robust,
    setting,
    squared,
)

LOSSES = {squared: L2, angular: COSINE, robust: ROBUST}
DECAY, ACTOR_RATE, CRITIC_RATE = 1e-2, 1e-4, 1e-3


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
        ((0.7, 0.0), robust),
        ((0.7, 0.3), robust),
    ],
)
def test_update_is_the_equations(
    name: str, weights: tuple[float, float], distance: Callable[..., Any]
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
    distance: Callable[..., Any],
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
    decayed = q.theta[: decayed_size(shapes[1])]
    distances = robust(batch.goes_on) if distance is robust else (distance, distance)
    critic_loss = (
        batch.critic_loss(q, targets, weights, *distances) + DECAY / 2 * (decayed**2).sum()
    )
    x = batch.normal(batch.f)
    actor_loss = -q(torch.cat([x, torch.tanh(pi(x))], 1)).mean()
    before = [part.copy() for part in (actor.theta, actor.target, critic.theta, critic.target)]

    rates = Rates(np.float32(GAMMA), np.float32(TAU), ACTOR_RATE, CRITIC_RATE, np.float32(DECAY))
    done, lost = update(
        actor, critic, 0, where.memory, rows[None], where.coordinates, where.scaling, rates,
        matching_of(weights, LOSSES[distance]), shapes, empty_report(1),
    )  # fmt: skip

    assert (done, lost) == (1, -1)
    assert_stepped(actor, before[0], actor_loss, pi, ACTOR_RATE)
    assert_stepped(critic, before[2], critic_loss, q, CRITIC_RATE)
    assert_followed(actor, before[1])
    assert_followed(critic, before[3])


@pytest.mark.parametrize("placebo", ["shuffled", "untargeted"])
def test_a_placebo_matches_what_says_nothing(placebo: str) -> None:
    where = setting("Pendulum")
    shapes = shapes_in(where, (16, 16), Tanh())
    actor, critic = (
        learned(not_small(shape, where.random))._replace(target=not_small(shape, where.random))
        for shape in shapes
    )
    rows = generator(5, "rows").integers(STORED, size=ROWS)
    batch = PlainBatch(where, rows)
    if placebo == "shuffled":
        batch.jacobian, batch.r_gradient = (
            part.roll(-1, 0) for part in (batch.jacobian, batch.r_gradient)
        )
    pi_target, q_target = Plain(actor.target, shapes[0]), Plain(critic.target, shapes[1])
    q = Plain(critic.theta, shapes[1])
    value, gradient = batch.targets(
        lambda x: q_target(torch.cat([x, torch.tanh(pi_target(x))], 1))[:, 0]
    )
    aim = torch.zeros_like(gradient) if placebo == "untargeted" else gradient
    loss = batch.critic_loss(q, (value, aim), (0.7, 0.3), squared)
    before = critic.theta.copy()
    rates = Rates(np.float32(GAMMA), np.float32(TAU), ACTOR_RATE, CRITIC_RATE, np.float32(0))
    told = update(
        actor, critic, 0, where.memory, rows[None], where.coordinates, where.scaling, rates,
        matching_of((0.7, 0.3), L2, placebo), shapes, empty_report(1),
    )  # fmt: skip
    assert told == (1, -1)
    assert_stepped(critic, before, loss, q, CRITIC_RATE)


def test_of_every_two_updates_one_matches() -> None:
    where = setting("Pendulum")
    shapes = shapes_in(where, (16, 16), Tanh())
    batches = generator(5, "rows").integers(STORED, size=(2, ROWS))
    rates = Rates(np.float32(GAMMA), np.float32(TAU), ACTOR_RATE, CRITIC_RATE, np.float32(DECAY))
    thetas = [not_small(shape, where.random) for shape in shapes]

    def updated(*parts: tuple[int, Any, tuple[float, float], int]) -> tuple[Any, Any, Any]:
        actor, critic = (learned(theta.copy()) for theta in thetas)
        for done, rows, weights, every in parts:
            matching, report = matching_of(weights, ROBUST, every=every), empty_report(len(rows))
            update(
                actor, critic, done, where.memory, rows, where.coordinates, where.scaling, rates,
                matching, shapes, report,
            )  # fmt: skip
        return actor.theta, critic.theta, report

    *once, report = updated((0, batches, (0.7, 0.3), 2))
    *apart, _ = updated((0, batches[:1], (0.7, 0.3), 1), (1, batches[1:], (0.0, 0.0), 1))
    *other_way, _ = updated((1, batches[:1], (0.7, 0.3), 2), (2, batches[1:], (0.7, 0.3), 2))
    for theta, same, other in zip(once, apart, other_way, strict=True):
        np.testing.assert_array_equal(theta, same)
        assert (theta != other).any(), "the count of updates decides, not the place in a cycle"
    assert report.gradient_loss[0] > report.gradient_loss[1] == 0
