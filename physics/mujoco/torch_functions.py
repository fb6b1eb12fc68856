"""TorchMujocoTask: a model whose reward and end are torch functions of one step.

Their derivatives are exact, by `torch.func`. As in `TorchEnvironment`, calls work in blocks of the
same size, so that a row's bits do not depend on its neighbours.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.func import grad, vmap

from physics.environment import BoolArray, FloatArray
from physics.mujoco.mujoco_task import MujocoTask
from physics.torch_environment import gradients_enabled
from physics.torch_task_check import outcome_mistakes

_BLOCK = 64


class TorchMujocoTask(MujocoTask):
    """A model with a reward and an end of one step, as functions that `torch.func.vmap` accepts."""

    @abstractmethod
    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        """The reward [] of one step."""

    def terminated(self, next_state: torch.Tensor) -> torch.Tensor:
        """Whether the episode ends there, bool []; by default it never does."""
        return torch.zeros_like(next_state[0], dtype=torch.bool)

    def function_mistakes(self) -> list[str]:
        """The mistakes in the two functions."""
        with gradients_enabled():
            mistakes = outcome_mistakes(self)
        of_functions = any(each.startswith(("reward", "terminated")) for each in mistakes)
        hint = ["functions of numpy arrays are declared by written_in='numpy'"]
        return mistakes + hint * of_functions

    def rewards(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> FloatArray:
        """See `MujocoTask.rewards`."""
        (rewards,) = by_rows(lambda *row: (self.reward(*row),), states, actions, next_states)
        return rewards

    def reward_gradients(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See `MujocoTask.reward_gradients`."""
        if not self.reward_is_differentiable:
            return np.zeros_like(states), np.zeros_like(actions), np.zeros_like(next_states)
        gradients = grad(self.reward, argnums=(0, 1, 2))
        by_state, by_action, by_next = by_rows(gradients, states, actions, next_states)
        return by_state, by_action, by_next

    def ends(self, next_states: FloatArray) -> BoolArray:
        """See `MujocoTask.ends`."""
        (ends,) = by_rows(lambda state: (self.terminated(state),), next_states)
        return ends


def by_rows(
    function: Callable[..., tuple[torch.Tensor, ...]], *arrays: FloatArray
) -> list[NDArray[Any]]:
    """The results of a function of one row for rows [batch, ...], block by block."""
    count = len(arrays[0])
    blocks = []
    for start in range(0, max(count, 1), _BLOCK):
        picked = np.minimum(np.arange(start, start + _BLOCK), count - 1)
        # For no rows, a row of zeros gives results of the right shapes.
        rows = [
            torch.from_numpy(array[picked] if count else np.zeros((1, *array.shape[1:])))
            for array in arrays
        ]
        with gradients_enabled():
            blocks.append([result.detach().numpy() for result in vmap(function)(*rows)])
    return [np.concatenate(column)[:count] for column in zip(*blocks, strict=True)]
