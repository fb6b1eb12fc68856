"""JAX task check: a task's functions, traced as JAX compiles them.

Each must return an array of its shape and dtype. Whether numbers are finite is checked in each
step.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from physics.drawing_check import drawing_mistakes
from physics.jax_engine import jax

if TYPE_CHECKING:
    from physics.jax_environment import JaxEnvironment

HOW = (
    "use jax.numpy's functions alone, no numpy or math, no float(), jnp.where or jax.lax.cond "
    "instead of if"
)


def function_mistakes(task: "JaxEnvironment") -> list[str]:
    """The mistakes in the functions of a task whose sizes are right."""
    state, action = np.zeros(task.state_size), np.zeros(task.action_size)
    n = task.state_size
    return [
        *_of_start(task),
        *_of_function("dynamics", task.dynamics, (state, action), (n,), np.float64),
        *_of_function("reward", task.reward, (state, action, state), (), np.float64),
        *_of_function("terminated", task.terminated, (state,), (), np.bool_),
    ]


def _of_start(task: "JaxEnvironment") -> list[str]:
    try:
        starts = task.initial_states(range(3))
    except ValueError as error:
        return [str(error)]
    except Exception as error:
        return [f"initial_state raised {type(error).__name__}: {error}"]
    return drawing_mistakes(task, starts[0])


def _of_function(
    name: str,
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    shape: tuple[int, ...],
    dtype: type[np.generic],
) -> list[str]:
    """The mistakes in a function of one row."""
    expected = f"must return an array {list(shape)} of {np.dtype(dtype)}"
    try:
        found = jax.eval_shape(function, *arguments)
    except jax.errors.JAXTypeError as error:
        return [f"{name} cannot be compiled by JAX: {HOW} ({type(error).__name__})"]
    except Exception as error:
        return [f"{name} raised {type(error).__name__}: {error}"]
    if not isinstance(found, jax.ShapeDtypeStruct):
        return [f"{name} {expected}, not {type(found).__name__}"]
    if found.shape != shape or found.dtype != dtype:
        return [f"{name} {expected}, not {list(found.shape)} of {found.dtype}"]
    return []
