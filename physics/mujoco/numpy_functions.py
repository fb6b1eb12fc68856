"""NumpyMujocoTask: a model whose reward and end are numpy functions of one step.

It is for rewards that torch cannot differentiate, such as a table. The reward's derivatives are
centred differences, of the same width as those of the dynamics.
"""

from abc import abstractmethod
from collections.abc import Iterator
from numbers import Real
from typing import Any

import numpy as np

from physics.drawing_check import drawing_mistakes
from physics.environment import BoolArray, FloatArray
from physics.mujoco.declaration_check import described
from physics.mujoco.mujoco_task import MujocoTask

ROWS = 3


class NumpyMujocoTask(MujocoTask):
    """A model with a reward and an end of one step."""

    @abstractmethod
    def reward(self, state: FloatArray, action: FloatArray, next_state: FloatArray) -> float:
        """The reward of one step, from arrays [n], [m] and [n]."""

    def terminated(self, next_state: FloatArray) -> bool:
        """Whether the episode ends there; by default it never does."""
        del next_state
        return False

    def function_mistakes(self) -> list[str]:
        """The mistakes in the two functions."""
        try:
            states = self.initial_states(range(ROWS))
        except Exception as error:
            return [f"start: {type(error).__name__}: {error}"]
        action = np.zeros(self.action_size)
        return [
            *_mistake("reward", "a number", Real, [(s, action, s) for s in states], self.reward),
            *_mistake("terminated", "True or False", bool | np.bool_, [(s,) for s in states],
                      self.terminated),
            *drawing_mistakes(self, states[0]),
        ]  # fmt: skip

    def rewards(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> FloatArray:
        """See `MujocoTask.rewards`."""
        rows = zip(states, actions, next_states, strict=True)
        return np.array([self.reward(*row) for row in rows], np.float64)

    def reward_gradients(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See `MujocoTask.reward_gradients`."""
        gradients = np.zeros_like(states), np.zeros_like(actions), np.zeros_like(next_states)
        if not self.reward_is_differentiable:
            return gradients
        for row in range(len(states)):
            arguments = [states[row], actions[row], next_states[row]]
            for place, gradient in enumerate(gradients):
                gradient[row] = self._gradient(arguments, place)
        return gradients

    def ends(self, next_states: FloatArray) -> BoolArray:
        """See `MujocoTask.ends`."""
        return np.array([self.terminated(state) for state in next_states], np.bool_)

    def _gradient(self, arguments: list[FloatArray], place: int) -> FloatArray:
        """The reward's differences in one of its arguments."""
        width, argument = self.difference, arguments[place]
        gradient = np.empty_like(argument)
        for i in range(len(argument)):
            ahead, behind = argument.copy(), argument.copy()
            ahead[i] += width
            behind[i] -= width
            high, low = (
                self.reward(*[moved if k == place else each for k, each in enumerate(arguments)])
                for moved in (ahead, behind)
            )
            gradient[i] = (high - low) / (2.0 * width)
        return gradient


def _mistake(
    name: str, expected: str, kind: Any, rows: list[tuple[FloatArray, ...]], function: Any
) -> Iterator[str]:
    """The first mistake of a function that is called on some rows."""
    for row in rows:
        try:
            result = function(*(argument.copy() for argument in row))
        except Exception as error:
            yield f"{name} raised {type(error).__name__}: {error}"
            return
        if not isinstance(result, kind):
            yield f"{name} must return {expected}, not {described(result)}"
            return
