"""A task of the catalogue with other rewards."""

from collections.abc import Callable

import numpy as np

import physics
from physics.drawing import Drawing
from physics.environment import Environment, FloatArray, Linearization, Transition


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
        for constant in ("name", "version", "state_size", "action_size", "horizon", "angles",
                         "hidden", "max_reward", "reward_is_differentiable"):  # fmt: skip
            setattr(self, constant, getattr(self._task, constant))
        super().__init__()

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return self._task.initial_state(generator)

    def draw(self, state: FloatArray) -> Drawing:
        return self._task.draw(state)

    def step(self, states: FloatArray, actions: FloatArray) -> Transition:
        step = self._task.step(states, actions)
        return step._replace(reward=self._change(states, step.reward))

    def differentiate(self, states: FloatArray, actions: FloatArray) -> Linearization:
        step, by_state, by_action, *gradients = self._task.differentiate(states, actions)
        step = step._replace(reward=self._change(states, step.reward))
        return Linearization(step, by_state, by_action, *(self._slope * g for g in gradients))


def times(name: str, factor: float) -> OtherRewards:
    """The task with all rewards multiplied."""
    return OtherRewards(name, lambda _, rewards: factor * rewards, factor)


def constant(name: str, reward: float) -> OtherRewards:
    """The task with a reward that never changes."""
    return OtherRewards(name, lambda _, rewards: np.full_like(rewards, reward), 0.0)
