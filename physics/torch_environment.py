"""TorchEnvironment: a task written as torch functions, its derivatives by `torch.func`.

The author writes the dynamics and the reward of one state; batches and Jacobians are derived:

    s' = dynamics(s, u),    r = reward(s, u, s'),    u = clip(a, -1, 1)
    J_s = d dynamics / ds,  J_a = d dynamics / du where a lies in the box, 0 elsewhere

The functions are traced at the first call (`physics/torch_trace.py`). A call then costs a few
tenths of a millisecond for a small task, while a compiled task costs microseconds: such a task is
quick to write, but not fast to run.

torch may choose another kernel, and round differently, for another batch size. So every call works
in blocks of 64 rows, the last block filled up with copies of its last row: a row's bits then do not
depend on its neighbours.

`torch.func` returns wrong Jacobians of `torch.linalg` where gradients are disabled. So every call
of an author's function is made with gradients enabled, whatever the caller's mode.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from typing import Any, Self

import numpy as np
import torch
from torch.func import grad, jacrev, vmap

from physics.environment import BoolArray, Environment, FloatArray
from physics.randomness import generator
from physics.torch_task_check import function_mistakes
from physics.torch_trace import Function, Tensors, traced

_BLOCK = 64


@contextmanager
def gradients_enabled() -> Iterator[None]:
    """Enable gradients, also within `torch.no_grad` and `torch.inference_mode`."""
    with torch.inference_mode(False), torch.enable_grad():
        yield


class TorchEnvironment(Environment):
    """A task with three torch functions of one state and one action.

    They must be pure and accepted by `torch.func.vmap`: `torch.where` instead of `if`.
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

    def function_mistakes(self) -> list[str]:
        """The mistakes in the task's functions."""
        with gradients_enabled():
            return function_mistakes(self)

    def step_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: BoolArray,
    ) -> int:
        """Step every row; see `Environment.step_kernel`."""
        if len(states):
            _fill(self._step_function, states, actions, (next_states, rewards, terminated))
        return -1

    def differentiate_kernel(self, states: FloatArray, actions: FloatArray, *outputs: Any) -> int:
        """Step and differentiate every row; see `Environment.differentiate_kernel`."""
        if len(states):
            _fill(self._differentiate_function, states, actions, outputs)
        return -1

    @cached_property
    def _step_function(self) -> Function:
        return self._traced(self.transitions)

    @cached_property
    def _differentiate_function(self) -> Function:
        return self._traced(self._linearizations)

    def _traced(self, function: Function) -> Function:
        """The function for blocks of rows, traced on start states."""
        states = self.initial_states(range(_BLOCK))
        actions = generator(0, "torch trace").uniform(-1.5, 1.5, (_BLOCK, self.action_size))
        with gradients_enabled():
            return traced(function, torch.from_numpy(states), torch.from_numpy(actions))

    def _linearizations(self, states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        """The transition and its derivatives."""
        return *self.transitions(states, actions), *self.derivatives(states, actions)

    def derivatives(self, states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        """The derivatives of a `Linearization` in its order, themselves differentiable.

        Args:
            states: float64 [batch, n].
            actions: float64 [batch, m].
        """
        return vmap(self.derivatives_of_row)(states, actions)

    def derivatives_of_row(self, state: torch.Tensor, action: torch.Tensor) -> Tensors:
        """The same of one state [n] and one action [m]."""
        u = action.clamp(-1.0, 1.0)
        within = (action.abs() <= 1.0).to(action.dtype)
        by_state, by_action = jacrev(self.dynamics, argnums=(0, 1))(state, u)
        r_state, r_action, r_next = self._reward_gradients(state, u)
        return by_state, by_action * within, r_state, r_action * within, r_next

    def _reward_gradients(self, state: torch.Tensor, action: torch.Tensor) -> Tensors:
        """The reward's partial derivatives in its three arguments."""
        following = self.dynamics(state, action)
        if not self.reward_is_differentiable:
            return torch.zeros_like(state), torch.zeros_like(action), torch.zeros_like(following)
        gradients: Callable[..., Tensors] = grad(self.reward, argnums=(0, 1, 2))
        return gradients(state, action, following)

    def with_tensors(self, values: Mapping[str, torch.Tensor]) -> Self:
        """The same task with tensors [] as values of parameters, to be differentiated in them."""
        return self._changed(values)

    def transitions(self, states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        """The fields of a `Transition` of rows, differentiable."""
        return vmap(self._transition)(states, actions.clamp(-1.0, 1.0))

    def _transition(self, state: torch.Tensor, action: torch.Tensor) -> Tensors:
        following = self.dynamics(state, action)
        return following, self.reward(state, action, following), self.terminated(following)


def _fill(
    function: Function,
    states: FloatArray,
    actions: FloatArray,
    outputs: tuple[FloatArray | BoolArray, ...],
) -> None:
    """Write a function's results for the rows, block by block, without the copied rows."""
    for start in range(0, len(states), _BLOCK):
        picked = np.minimum(np.arange(start, start + _BLOCK), len(states) - 1)
        with gradients_enabled():
            results = function(torch.from_numpy(states[picked]), torch.from_numpy(actions[picked]))
        for result, output in zip(results, outputs, strict=True):
            rows = output[start : start + _BLOCK]
            rows[:] = result.detach().numpy()[: len(rows)]
