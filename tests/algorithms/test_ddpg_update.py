"""One update of the compiled kernels against the equations written plainly in torch, float64.

The torch side knows nothing of passes and adjoints: it differentiates the losses as learners read
them, twice where the hybrid needs it.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

import physics
from algorithms import network
from algorithms.ddpg_update import Rates, empty_report, update
from algorithms.losses import matching_of
from algorithms.network import Shape
from algorithms.optimizer import Learned, learned
from algorithms.replay import Memory
from algorithms.scaling import Coordinates, Scaling, Statistics, coordinates_of
from algorithms.target_jacobian import fold
from physics.randomness import generator

STORED, ROWS, GAMMA, TAU, DECAY = 200, 32, 0.97, 0.05, 1e-2
ACTOR_RATE, CRITIC_RATE = 1e-4, 1e-3

Distance = Callable[[Tensor, Tensor], Tensor]
Setting = tuple[Memory, Coordinates, Scaling, Learned, Learned, tuple[Shape, Shape]]


def setting(name: str) -> Setting:
    """Real transitions of a task with random networks whose outputs are not small."""
    random, task = generator(3, name), physics.make(name)
    coordinates = coordinates_of(task)
    states, actions = task.sample(random, STORED)
    steps = task.differentiate(states, np.clip(actions, -1.0, 1.0))
    features = task.features(states).astype(np.float32)
    memory = Memory(
        features,
        np.clip(actions, -1.0, 1.0).astype(np.float32),
        steps.transition.reward.astype(np.float32),
        task.features(steps.transition.next_state).astype(np.float32),
        (np.arange(STORED) % 3 > 0).astype(np.float32),  # a third are terminal
        *fold(task, coordinates, steps),
    )
    statistics = Statistics(coordinates, task.action_size)
    statistics.observe(features)
    statistics.set_value_scale(-3.0, 7.0)
    inputs, m = task.feature_size, task.action_size
    shapes = Shape(inputs, 16, m), Shape(inputs + m, 16, 1)
    pair = []
    for shape in shapes:
        now, later = (network.initial(shape, random) for _ in range(2))
        now += 0.1 * random.standard_normal(now.size, np.float32)
        later += 0.1 * random.standard_normal(later.size, np.float32)
        pair.append(learned(now)._replace(target=later))
    return memory, coordinates, statistics.scaling(), pair[0], pair[1], shapes


class Plain:
    """A network of algorithms.network in torch."""

    def __init__(self, theta: NDArray[np.float32], shape: Shape) -> None:
        self.theta = torch.tensor(theta, dtype=torch.float64, requires_grad=True)
        i, h, o = shape
        self.sizes = [(i, h), (h, h), (h, o), (h,), (h,), (o,), (h,), (h,), (h,), (h,)]

    def __call__(self, x: Tensor) -> Tensor:
        parts, at = [], 0
        for size in self.sizes:
            length = int(np.prod(size))
            parts.append(self.theta[at : at + length].reshape(size))
            at += length
        w1, w2, v, b1, b2, d, g1, c1, g2, c2 = parts
        hidden = torch.nn.functional.layer_norm
        h1 = torch.tanh(hidden(x @ w1 + b1, b1.shape, g1, c1))
        h2 = torch.tanh(hidden(h1 @ w2 + b2, b2.shape, g2, c2))
        return h2 @ v + d


def gradient_of(value: Tensor, *inputs: Tensor) -> tuple[Tensor, ...]:
    return torch.autograd.grad(value.sum(), inputs, create_graph=True)


def squared(own: Tensor, target: Tensor) -> Tensor:
    return ((own - target) ** 2).sum(1)


def angular(own: Tensor, target: Tensor) -> Tensor:
    """Equation 3, both vectors made longer by one more entry, which the product leaves out."""
    own_norm, target_norm = (((each**2).sum(1) + 1e-6).sqrt() for each in (own, target))
    return 1 - (own * target).sum(1) / (own_norm * target_norm)


def losses(
    where: Setting, rows: NDArray[np.int64], w1: float, w2: float, distance: Distance
) -> tuple[Tensor, Plain, Tensor, Plain]:
    """The critic's loss with weight decay, and the actor's, with the networks they belong to."""
    memory, c, scaling, learned_actor, learned_critic, shapes = where
    f, a, r, f_next, goes_on, r_gradient, jacobian = (
        torch.tensor(part[rows], dtype=torch.float64) for part in memory
    )
    mean, inverse, unit = (torch.tensor(part, dtype=torch.float64) for part in scaling[:3])
    value_mean, value_std = float(scaling.value_mean), float(scaling.value_std)
    pi, pi_target = (Plain(t, shapes[0]) for t in (learned_actor.theta, learned_actor.target))
    q, q_target = (Plain(t, shapes[1]) for t in (learned_critic.theta, learned_critic.target))

    def normal(features: Tensor) -> Tensor:
        return ((features - mean) * inverse).clamp(-5, 5)

    f_next.requires_grad_()
    x_next = normal(f_next)
    following = q_target(torch.cat([x_next, torch.tanh(pi_target(x_next))], 1))[:, 0]
    following = value_mean + value_std * following
    (by_next,) = gradient_of(following, f_next)
    discount = GAMMA * goes_on
    target = ((r + discount * following - value_mean) / value_std).detach()
    target_gradient = r_gradient + discount[:, None] * torch.einsum("bf,bfz->bz", by_next, jacobian)
    target_gradient = (target_gradient * unit / value_std).detach()

    f.requires_grad_()
    a.requires_grad_()
    value = q(torch.cat([normal(f), a], 1))[:, 0]
    by_f, by_a = gradient_of(value, f, a)
    slopes = torch.tensor(c.factor) * f[:, torch.tensor(c.partner)] + torch.tensor(c.offset)
    by_s = torch.zeros(len(rows), len(c.seen), dtype=torch.float64)
    by_s = by_s.index_add(1, torch.tensor(c.source), by_f * slopes.detach())
    own_gradient = torch.cat([by_s, by_a], 1) * unit
    seen = len(c.seen)
    (own_s, own_a), (target_s, target_a) = (
        (each[:, :seen], each[:, seen:]) for each in (own_gradient, target_gradient)
    )
    matched = w1 * distance(own_a, target_a) + w2 * distance(own_s, target_s)
    decayed = q.theta[: network.decayed_size(shapes[1])]
    critic_loss = ((value - target) ** 2 + matched).mean() + DECAY / 2 * (decayed**2).sum()

    x = normal(f.detach())
    actor_loss = -q(torch.cat([x, torch.tanh(pi(x))], 1)).mean()
    return critic_loss, q, actor_loss, pi


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
    name: str, weights: tuple[float, float], distance: Distance
) -> None:
    where = setting(name)
    memory, coordinates, scaling, actor, critic, shapes = where
    rows = generator(5, "rows").integers(STORED, size=ROWS)
    critic_loss, q, actor_loss, pi = losses(where, rows, *weights, distance)
    (q_gradient,) = torch.autograd.grad(critic_loss, q.theta)
    (pi_gradient,) = torch.autograd.grad(actor_loss, pi.theta)
    before = [part.copy() for part in (actor.theta, actor.target, critic.theta, critic.target)]

    rates = Rates(np.float32(GAMMA), np.float32(TAU), ACTOR_RATE, CRITIC_RATE, np.float32(DECAY))
    done = update(
        actor, critic, 0, memory, rows[None], coordinates, scaling, rates,
        matching_of(weights, by_cosine=distance is angular), shapes, empty_report(1),
    )  # fmt: skip

    assert done == 1
    for net, gradient, rate, old, old_target in (
        (actor, pi_gradient, ACTOR_RATE, before[0], before[1]),
        (critic, q_gradient, CRITIC_RATE, before[2], before[3]),
    ):
        ours = net.m / np.float32(0.1)  # Adam's first mean is a tenth of the gradient
        scale = float(gradient.abs().max())
        np.testing.assert_allclose(ours / scale, gradient.numpy() / scale, rtol=2e-3, atol=2e-5)
        np.testing.assert_allclose(net.theta, adam_step(old, ours, rate), rtol=0, atol=1e-3 * rate)
        followed = old_target + TAU * (net.theta - old_target)
        np.testing.assert_allclose(net.target, followed, rtol=1e-5, atol=1e-7)


def adam_step(theta: NDArray[Any], gradient: NDArray[Any], rate: float) -> NDArray[Any]:
    """The first step of torch's Adam."""
    parameter = torch.nn.Parameter(torch.tensor(theta, dtype=torch.float64))
    parameter.grad = torch.tensor(gradient, dtype=torch.float64)
    torch.optim.Adam([parameter], lr=rate, eps=1e-8 / np.sqrt(1e-3)).step()
    return parameter.detach().numpy()
