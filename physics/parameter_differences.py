"""Parameter differences: derivatives of steps in parameters, for tasks that do not have exact ones.

    D(h) = (8 [f(p + h) - f(p - h)] - [f(p + 2h) - f(p - 2h)]) / 12h

for each parameter p, with the largest of several widths h for which all of p +- h and p +- 2h leave
the step on its smooth piece (`Environment.pieces`), or with the smallest width. Near an end of the
parameter's range the centre moves inwards by 2h. For steps of a smooth piece this agrees with the
derivative to about 1e-9.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physics.parameter import Parameter, declared

if TYPE_CHECKING:
    from physics.environment import Environment

FloatArray = NDArray[np.float64]

WIDTHS = (1e-3, 1e-4, 1e-5)
"""Relative to the parameter, or to 1."""
_STENCIL = (1.0, -1.0, 2.0, -2.0)
_WEIGHTS = np.array([8.0, -8.0, -1.0, 1.0]) / 12.0


def by_differences(
    task: "Environment", states: FloatArray, actions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """d next_state / d p [batch, n, k], and the total derivative of the reward [batch, k]."""
    columns = [
        _column(task, parameter, states, actions) for parameter in declared(type(task)).values()
    ]
    together = np.stack(columns, axis=2) if columns else np.empty((*states.shape, 0))
    return together[:, :-1], together[:, -1]


def _column(
    task: "Environment", parameter: Parameter, states: FloatArray, actions: FloatArray
) -> FloatArray:
    """The derivatives of next state and reward [batch, n + 1] in one parameter."""
    value = getattr(task, parameter.name)
    found, is_left = np.empty((len(states), task.state_size + 1)), np.ones(len(states), np.bool_)
    for width in WIDTHS:
        rows = np.flatnonzero(is_left)
        if not rows.size:
            break
        h = width * max(abs(value), 1.0)
        centre = min(max(value, parameter.least + 2 * h), parameter.greatest - 2 * h)

        def moved(point: float, centre: float = centre, h: float = h) -> "Environment":
            return task.with_parameters(**{parameter.name: centre + point * h})

        found[rows], is_smooth = _at_width(moved, task, states[rows], actions[rows], h)
        is_left[rows] = ~is_smooth
    return found


def _at_width(
    moved: Callable[[float], "Environment"],
    task: "Environment",
    states: FloatArray,
    actions: FloatArray,
    h: float,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """D(h) for these rows [batch, n + 1], and which rows stay on their smooth piece."""
    here = task.pieces(states, actions).piece
    slope, is_smooth = np.zeros((len(states), states.shape[1] + 1)), np.ones(len(states), np.bool_)
    for point, weight in zip(_STENCIL, _WEIGHTS, strict=True):
        other = moved(point)
        following, reward, _ = other.step(states, actions)
        slope += weight / h * np.concatenate([following, reward[:, None]], axis=1)
        is_smooth &= (other.pieces(states, actions).piece == here).all(axis=1)
    return slope, is_smooth
