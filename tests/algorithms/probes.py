"""Probes: tasks so small that the best action is known, to hold learners against.

Bandit           one step:   r = -(a - s / 2)^2                                        a = s / 2
Postponed        two steps:  the first action is remembered, the second earns          a = 0.4
                             r = -(m - 0.4)^2 of the memory m, whatever it is
Integrator       ten steps:  s' = s + B a,  r = -s'^2 - R a^2                           a = -K s

K by the Riccati equation with the discount gamma, P the discounted cost to go:

    M = 1 + gamma P,   K = B M / (R + B^2 M),   P = M (1 - B K)^2 + R K^2
"""

from abc import abstractmethod
from typing import Any

import numpy as np

from physics.drawing import Drawing
from physics.environment import BoolArray, Environment, FloatArray

B, R, GAMMA = 0.5, 0.3, 0.99


class Probe(Environment):
    """A task with a known answer, for actions in the box."""

    version = 1
    action_size = 1
    max_reward = 0.0

    @abstractmethod
    def answer(self, s: FloatArray) -> FloatArray:
        """The best actions [b, 1] in states [b, n]."""

    @abstractmethod
    def advance(
        self, s: FloatArray, a: FloatArray, n: FloatArray, r: FloatArray, terminated: BoolArray
    ) -> None:
        """Fill in the transition."""

    @abstractmethod
    def slopes(self, s: FloatArray, a: FloatArray, n: FloatArray, *derivatives: FloatArray) -> None:
        """Fill in the derivatives, all zeros so far, of the transition to n."""

    def step_kernel(self, s: FloatArray, a: FloatArray, *transition: Any) -> int:
        self.advance(s, a, *transition)
        return -1

    def differentiate_kernel(self, s: FloatArray, a: FloatArray, *outputs: Any) -> int:
        self.advance(s, a, *outputs[:3])
        for derivative in outputs[3:]:
            derivative[:] = 0.0
        self.slopes(s, a, outputs[0], *outputs[3:])
        return -1

    def draw(self, state: FloatArray) -> Drawing:
        raise NotImplementedError("nothing to see")


class Bandit(Probe):
    """See above."""

    name = "Bandit"
    state_size = 1
    horizon = 1

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return generator.uniform(-1.0, 1.0, 1)

    def answer(self, s: FloatArray) -> FloatArray:
        return s / 2

    def advance(
        self, s: FloatArray, a: FloatArray, n: FloatArray, r: FloatArray, terminated: BoolArray
    ) -> None:
        n[:] = s
        r[:] = -((a - s / 2) ** 2)[:, 0]
        terminated[:] = True

    def slopes(self, s: FloatArray, a: FloatArray, n: FloatArray, *derivatives: FloatArray) -> None:
        by_state, _, r_state, r_action, _ = derivatives
        by_state[:] = 1.0
        r_state[:] = a - s / 2
        r_action[:] = -2 * (a - s / 2)


class Postponed(Probe):
    """See above; the state is (which step, memory)."""

    name = "Postponed"
    state_size = 2
    horizon = 2

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        del generator
        return np.zeros(2)

    def answer(self, s: FloatArray) -> FloatArray:
        return np.full((len(s), 1), 0.4)

    def advance(
        self, s: FloatArray, a: FloatArray, n: FloatArray, r: FloatArray, terminated: BoolArray
    ) -> None:
        second = s[:, 0] > 0.5
        n[:, 0] = s[:, 0] + 1.0
        n[:, 1] = np.where(second, s[:, 1], a[:, 0])
        r[:] = np.where(second, -((s[:, 1] - 0.4) ** 2), 0.0)
        terminated[:] = second

    def slopes(self, s: FloatArray, a: FloatArray, n: FloatArray, *derivatives: FloatArray) -> None:
        by_state, by_action, r_state, _, _ = derivatives
        second = s[:, 0] > 0.5
        by_state[:, 0, 0] = 1.0
        by_state[:, 1, 1] = second
        by_action[:, 1, 0] = ~second
        r_state[:, 1] = np.where(second, -2 * (s[:, 1] - 0.4), 0.0)


class Integrator(Probe):
    """See above."""

    name = "Integrator"
    state_size = 1
    horizon = 10

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return generator.uniform(-0.8, 0.8, 1)

    def answer(self, s: FloatArray) -> FloatArray:
        return -gain() * s

    def advance(
        self, s: FloatArray, a: FloatArray, n: FloatArray, r: FloatArray, terminated: BoolArray
    ) -> None:
        n[:] = s + B * a
        r[:] = (-(n**2) - R * a**2)[:, 0]
        terminated[:] = False

    def slopes(self, s: FloatArray, a: FloatArray, n: FloatArray, *derivatives: FloatArray) -> None:
        by_state, by_action, _, r_action, r_next = derivatives
        by_state[:] = 1.0
        by_action[:] = B
        r_action[:] = -2 * R * a
        r_next[:] = -2 * n


def gain() -> float:
    """K."""
    cost, k = 0.0, 0.0
    for _ in range(1000):
        m = 1 + GAMMA * cost
        k = B * m / (R + B**2 * m)
        cost = m * (1 - B * k) ** 2 + R * k**2
    return k
