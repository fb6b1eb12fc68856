"""TorchEnvironment: a task written as torch functions, its derivatives by `torch.func`.

The author writes the dynamics and the reward of one state; batches and Jacobians follow:

    s' = dynamics(s, u),    r = reward(s, u, s'),    u = clip(a, -1, 1)
    J_s = d dynamics / ds,  J_a = d dynamics / du where a lies in the box, 0 elsewhere

It costs some milliseconds a call, where a compiled task costs microseconds: the quick way to a new
task, not the fast one.

torch may choose another kernel, and round differently, for another batch size. So every call works
in blocks of the same 64 rows, the last one filled up with copies of its last row: a row's bits then
do not depend on its neighbours.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import torch
from torch.func import grad, jacrev, vmap

from physics.environment import BoolArray, Environment, FloatArray

_BLOCK = 64


class TorchEnvironment(Environment):
    """A task whose three functions are torch's, of one state and one action.

    They must be pure, and such as `torch.func.vmap` takes: `torch.where` instead of `if`.
    """

    @abstractmethod
    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        """The next state [n] of a state [n] under an action [m] within the box."""

    @abstractmethod
    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        """The reward [] of one step."""

    def terminated(self, next_state: torch.Tensor) -> torch.Tensor:
        """Whether the episode ends there, bool []; by default it never does."""
        return torch.zeros_like(next_state[0], dtype=torch.bool)

    def step_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: BoolArray,
    ) -> int:
        """Step every row; see `Environment.step_kernel`."""
        for rows, s, a in _blocks(states, actions):
            _fill(
                vmap(self._transition)(s, a.clamp(-1.0, 1.0)),
                (next_states, rewards, terminated),
                rows,
            )
        return -1

    def differentiate_kernel(self, states: FloatArray, actions: FloatArray, *outputs: Any) -> int:
        """Step and differentiate every row; see `Environment.differentiate_kernel`."""
        self.step_kernel(states, actions, *outputs[:3])
        for rows, s, a in _blocks(states, actions):
            u = a.clamp(-1.0, 1.0)
            within = (a.abs() <= 1.0).to(a.dtype)
            following = vmap(self.dynamics)(s, u)
            by_state, by_action = vmap(jacrev(self.dynamics, argnums=(0, 1)))(s, u)
            gradients: Callable[..., tuple[torch.Tensor, ...]] = grad(
                self.reward, argnums=(0, 1, 2)
            )
            r_state, r_action, r_next = vmap(gradients)(s, u, following)
            results = (by_state, by_action * within[:, None], r_state, r_action * within, r_next)
            _fill(results, outputs[3:], rows)
        return -1

    def _transition(
        self, state: torch.Tensor, action: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        following = self.dynamics(state, action)
        return following, self.reward(state, action, following), self.terminated(following)


def _blocks(
    states: FloatArray, actions: FloatArray
) -> Iterator[tuple[slice, torch.Tensor, torch.Tensor]]:
    """The rows in blocks of 64, the last filled up with copies of the last row."""
    for start in range(0, len(states), _BLOCK):
        picked = np.minimum(np.arange(start, start + _BLOCK), len(states) - 1)
        rows = slice(start, min(start + _BLOCK, len(states)))
        yield rows, torch.from_numpy(states[picked]), torch.from_numpy(actions[picked])


def _fill(
    results: tuple[torch.Tensor, ...], outputs: tuple[FloatArray | BoolArray, ...], rows: slice
) -> None:
    """Copy a block's results, without the copies that filled it up."""
    for result, output in zip(results, outputs, strict=True):
        output[rows] = result.detach().numpy()[: rows.stop - rows.start]
