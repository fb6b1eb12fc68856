"""A task of the catalogue with other rewards."""

from collections.abc import Callable
from typing import Any

import numpy as np

import physics
from physics.drawing import Drawing
from physics.environment import Environment, FloatArray

CONSTANTS = (
    "name", "version", "state_size", "action_size", "horizon", "angles", "hidden", "max_reward",
    "reward_is_differentiable",
)  # fmt: skip


class OtherRewards(Environment):
    """Rewards are `change(states, rewards)`, their gradients `slope` times what they were."""

    def __init__(
        self,
        name: str,
        change: Callable[[FloatArray, FloatArray], FloatArray],
        slope: float = 1.0,
    ) -> None:
        self._task = physics.make(name)
        self._change, self._slope = change, slope
        for constant in CONSTANTS:
            setattr(self, constant, getattr(self._task, constant))
        super().__init__()

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return self._task.initial_state(generator)

    def draw(self, state: FloatArray) -> Drawing:
        return self._task.draw(state)

    def step_kernel(self, states: FloatArray, actions: FloatArray, *step: Any) -> int:
        unsolved = self._task.step_kernel(states, actions, *step)
        step[1][:] = self._change(states, step[1])
        return unsolved

    def differentiate_kernel(self, states: FloatArray, actions: FloatArray, *outputs: Any) -> int:
        unsolved = self._task.differentiate_kernel(states, actions, *outputs)
        outputs[1][:] = self._change(states, outputs[1])
        for gradient in outputs[5:]:
            gradient[:] *= self._slope
        return unsolved


def times(name: str, factor: float) -> OtherRewards:
    """The task with all rewards multiplied."""
    return OtherRewards(name, lambda _, rewards: factor * rewards, factor)


def constant(name: str, reward: float) -> OtherRewards:
    """The task with a reward that never changes."""
    return OtherRewards(name, lambda _, rewards: np.full_like(rewards, reward), 0.0)
