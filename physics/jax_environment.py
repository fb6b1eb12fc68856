"""JaxEnvironment: a task written as JAX functions, its derivatives by `jax.jacfwd`.

The author writes the dynamics and the reward of one state; batches and Jacobians are compiled from
them:

    s' = dynamics(s, u),    r = reward(s, u, s'),    u = clip(a, -1, 1)
    J_s = d dynamics / ds,  J_a = d dynamics / du where a lies in the box, 0 elsewhere

Forward mode also supports loops of unknown length, such as the solver in a step of MJX. Everything
is computed in float64 on the CPU and one thread (jax_engine.py).

XLA may round differently for another batch size. So every call works in blocks of the same number
of rows, the last block filled up with copies of its last row: a row's bits then do not depend on
its neighbours.
"""

import time
from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from physics.environment import BoolArray, Environment, FloatArray
from physics.jax_engine import float64_on_cpu, jax, jnp
from physics.jax_task_check import function_mistakes

Arrays = tuple[Any, ...]


class JaxEnvironment(Environment):
    """A task with three JAX functions of one state and one action.

    They must be pure and accepted by `jax.jit`: `jnp.where` or `jax.lax.cond` instead of `if`.
    """

    block: ClassVar[int] = 16
    """The number of rows in a block."""

    @abstractmethod
    def dynamics(self, state: Any, action: Any) -> Any:
        """The next state [n] of a state [n] under an action [m] within the box."""

    @abstractmethod
    def reward(self, state: Any, action: Any, next_state: Any) -> Any:
        """The reward [] of one step."""

    def terminated(self, next_state: Any) -> Any:
        """Whether the episode ends there, bool []; by default it never does."""
        del next_state
        return jnp.asarray(False)

    def function_mistakes(self) -> list[str]:
        """The mistakes in the task's functions."""
        with float64_on_cpu():
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
        _fill(self._transitions, (states, actions), (next_states, rewards, terminated), self.block)
        return -1

    def differentiate_kernel(self, states: FloatArray, actions: FloatArray, *outputs: Any) -> int:
        """Step and differentiate every row; see `Environment.differentiate_kernel`."""
        _fill(self._transitions, (states, actions), outputs[:3], self.block)
        _fill(self._derivatives, (states, actions, outputs[0]), outputs[3:], self.block)
        return -1

    def compile(self) -> float:
        """Compile the functions; return the seconds it took."""
        start = time.perf_counter()
        self.differentiate(self.initial_states([0]), np.zeros((1, self.action_size)))
        return time.perf_counter() - start + super().compile()

    @cached_property
    def _transitions(self) -> Callable[..., Arrays]:
        """A compiled function of rows that returns the fields of a `Transition`."""
        compiled: Callable[..., Arrays] = jax.jit(jax.vmap(self._transition))
        return compiled

    @cached_property
    def _derivatives(self) -> Callable[..., Arrays]:
        """A compiled function of rows that returns the derivatives of a `Linearization`."""
        compiled: Callable[..., Arrays] = jax.jit(jax.vmap(self._derivatives_of_row))
        return compiled

    def _transition(self, state: Any, action: Any) -> Arrays:
        action = jnp.clip(action, -1.0, 1.0)
        following = self.dynamics(state, action)
        return following, self.reward(state, action, following), self.terminated(following)

    def _derivatives_of_row(self, state: Any, action: Any, following: Any) -> Arrays:
        """The derivatives of a step that leads to `following`, which is already known."""
        u, within = jnp.clip(action, -1.0, 1.0), jnp.abs(action) <= 1.0
        by_state, by_action = jax.jacfwd(self.dynamics, argnums=(0, 1))(state, u)
        r_state, r_action, r_next = self._reward_gradients(state, u, following)
        return by_state, by_action * within, r_state, r_action * within, r_next

    def _reward_gradients(self, state: Any, action: Any, following: Any) -> Arrays:
        """The reward's partial derivatives in its three arguments."""
        if not self.reward_is_differentiable:
            return jnp.zeros_like(state), jnp.zeros_like(action), jnp.zeros_like(following)
        gradients: Arrays = jax.jacfwd(self.reward, argnums=(0, 1, 2))(state, action, following)
        return gradients


def _fill(
    function: Callable[..., Arrays],
    inputs: tuple[FloatArray, ...],
    outputs: tuple[FloatArray | BoolArray, ...],
    block: int,
) -> None:
    """Write a function's results for the rows, block by block, without the copied rows."""
    for start in range(0, len(inputs[0]), block):
        picked = np.minimum(np.arange(start, start + block), len(inputs[0]) - 1)
        with float64_on_cpu():
            results = function(*(each[picked] for each in inputs))
        for result, output in zip(results, outputs, strict=True):
            rows = output[start : start + block]
            rows[:] = np.asarray(result)[: len(rows)]
