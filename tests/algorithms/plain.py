"""What updates are held against: networks, normalisation and Adam written plainly, torch, float64.

It knows nothing of passes and adjoints.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import physics
from algorithms.experience.replay import Memory
from algorithms.experience.target_jacobian import fold
from algorithms.networks import network
from algorithms.networks.activation import ELU, ReLU, SiLU, Tanh
from algorithms.networks.network import Shape
from algorithms.networks.optimizer import Learned
from algorithms.networks.scaling import Coordinates, Scaling, Statistics, coordinates_of
from physics.environment import Environment
from physics.randomness import generator

ACTIVATIONS: dict[type, Callable[[Tensor], Tensor]] = {
    Tanh: torch.tanh,
    ELU: torch.nn.functional.elu,
    SiLU: torch.nn.functional.silu,
    ReLU: torch.relu,
}
STORED, ROWS, GAMMA, TAU = 200, 32, 0.97, 0.05


class Setting(NamedTuple):
    """Real transitions of a task, and what normalises them."""

    task: Environment
    states: NDArray[np.float64]
    actions: NDArray[np.float64]
    memory: Memory
    coordinates: Coordinates
    scaling: Scaling
    random: np.random.Generator


def setting(name: str) -> Setting:
    """Of a third of the transitions the task's end is made."""
    random, task = generator(3, name), physics.make(name)
    coordinates = coordinates_of(task)
    states, actions = task.sample(random, STORED)
    actions = np.clip(actions, -1.0, 1.0)
    steps = task.differentiate(states, actions)
    features = task.features(states).astype(np.float32)
    memory = Memory(
        features,
        actions.astype(np.float32),
        steps.transition.reward.astype(np.float32),
        task.features(steps.transition.next_state).astype(np.float32),
        (np.arange(STORED) % 3 > 0).astype(np.float32),
        *fold(task, coordinates, steps),
    )
    statistics = Statistics(coordinates, task.action_size)
    statistics.observe(features)
    statistics.set_value_scale(-3.0, 7.0)
    return Setting(task, states, actions, memory, coordinates, statistics.scaling(), random)


def not_small(shape: Shape, random: np.random.Generator) -> NDArray[np.float32]:
    """Parameters of a network whose outputs are not small."""
    theta = network.initial(shape, random)
    theta += 0.1 * random.standard_normal(theta.size, np.float32)
    return theta


class Plain:
    """A network of algorithms.networks.network."""

    def __init__(self, theta: NDArray[np.float32], shape: Shape) -> None:
        self.theta = torch.tensor(theta, dtype=torch.float64, requires_grad=True)
        units = [shape.inputs, *shape.hidden, shape.outputs]
        products = [*pairwise(units)]
        norms = [(h,) for h in shape.hidden for _ in range(2)]
        self.sizes = [*products, *((h,) for h in units[1:]), *norms]
        self.activation = ACTIVATIONS[type(shape.activation)]
        self.layers = len(shape.hidden)

    def __call__(self, x: Tensor) -> Tensor:
        parts, at = [], 0
        for size in self.sizes:
            length = int(np.prod(size))
            parts.append(self.theta[at : at + length].reshape(size))
            at += length
        weights, others = parts[: self.layers + 1], parts[self.layers + 1 :]
        biases, norms = others[: self.layers + 1], others[self.layers + 1 :]
        for k in range(self.layers):
            gain, shift = norms[2 * k : 2 * k + 2]
            z = x @ weights[k] + biases[k]
            x = self.activation(torch.nn.functional.layer_norm(z, z.shape[1:], gain, shift))
        return x @ weights[-1] + biases[-1]


class PlainBatch:
    """Some transitions, and the arithmetic of normalised units on them."""

    def __init__(self, where: Setting, rows: NDArray[np.int64]) -> None:
        self.f, self.a, self.r, self.f_next, self.goes_on, self.r_gradient, self.jacobian = (
            torch.tensor(part[rows], dtype=torch.float64) for part in where.memory
        )
        self.mean, self.inverse, self.unit = (
            torch.tensor(part, dtype=torch.float64) for part in where.scaling[:3]
        )
        self.value_mean = float(where.scaling.value_mean)
        self.value_std = float(where.scaling.value_std)
        self.coordinates = where.coordinates

    def normal(self, features: Tensor) -> Tensor:
        return ((features - self.mean) * self.inverse).clamp(-5, 5)

    def targets(
        self, following: Callable[[Tensor], Tensor], reward_scale: float = 1.0
    ) -> tuple[Tensor, Tensor]:
        """Equation 2: the target and its gradient, from the normalised value [b] of features."""
        f_next = self.f_next.clone().requires_grad_()
        value = self.value_mean + self.value_std * following(self.normal(f_next))
        (by_next,) = gradient_of(value, f_next)
        discount = GAMMA * self.goes_on
        target = (reward_scale * self.r + discount * value - self.value_mean) / self.value_std
        carried = torch.einsum("bf,bfz->bz", by_next, self.jacobian)
        gradient = reward_scale * self.r_gradient + discount[:, None] * carried
        return target.detach(), (gradient * self.unit / self.value_std).detach()

    def value_and_gradient(self, q: Plain) -> tuple[Tensor, Tensor]:
        """Q [b] at the batch, and its gradient [b, C + m] in normalised coordinates."""
        c, f, a = self.coordinates, self.f.clone().requires_grad_(), self.a.clone().requires_grad_()
        value = q(torch.cat([self.normal(f), a], 1))[:, 0]
        by_f, by_a = gradient_of(value, f, a)
        slopes = torch.tensor(c.factor) * f[:, torch.tensor(c.partner)] + torch.tensor(c.offset)
        by_s = torch.zeros(len(f), len(c.seen), dtype=torch.float64)
        by_s = by_s.index_add(1, torch.tensor(c.source), by_f * slopes.detach())
        return value, torch.cat([by_s, by_a], 1) * self.unit

    def critic_loss(
        self,
        q: Plain,
        targets: tuple[Tensor, Tensor],
        weights: tuple[float, float],
        distance: Callable[[Tensor, Tensor], Tensor],
    ) -> Tensor:
        """The value loss and the weighted distances of the gradients."""
        value, own = self.value_and_gradient(q)
        target, aim = targets
        seen = len(self.coordinates.seen)
        by_action = distance(own[:, seen:], aim[:, seen:])
        by_state = distance(own[:, :seen], aim[:, :seen])
        return ((value - target) ** 2 + weights[0] * by_action + weights[1] * by_state).mean()


def squared(own: Tensor, target: Tensor) -> Tensor:
    """The L2 distance of gradients."""
    return ((own - target) ** 2).sum(1)


def gradient_of(value: Tensor, *inputs: Tensor) -> tuple[Tensor, ...]:
    return torch.autograd.grad(value.sum(), inputs, create_graph=True)


def assert_stepped(
    net: Learned, before: NDArray[np.float32], loss: Tensor, plain: Plain, rate: float
) -> None:
    """That the network took Adam's first step down the loss."""
    (gradient,) = torch.autograd.grad(loss, plain.theta)
    ours = net.m / np.float32(0.1)  # Adam's first mean is a tenth of the gradient
    scale = float(gradient.abs().max())
    np.testing.assert_allclose(ours / scale, gradient.numpy() / scale, rtol=2e-3, atol=2e-5)
    np.testing.assert_allclose(net.theta, adam_step(before, ours, rate), rtol=0, atol=1e-3 * rate)


def assert_followed(net: Learned, before: NDArray[np.float32]) -> None:
    """That the target went its share of the way to the network."""
    followed = before + TAU * (net.theta - before)
    np.testing.assert_allclose(net.target, followed, rtol=1e-5, atol=1e-7)


def adam_step(theta: NDArray[Any], gradient: NDArray[Any], rate: float) -> NDArray[Any]:
    """The first step of torch's Adam."""
    parameter = torch.nn.Parameter(torch.tensor(theta, dtype=torch.float64))
    parameter.grad = torch.tensor(gradient, dtype=torch.float64)
    torch.optim.Adam([parameter], lr=rate, eps=1e-8 / np.sqrt(1e-3)).step()
    return parameter.detach().numpy()
