"""Derivatives of MuJoCo's steps, by differences of a given width.

Where possible, the engine's own `mjd_transitionFD` differentiates each substep, and the results are
multiplied: it takes differences in the tangent space, and recomputes only what an input changes. It
does not support the integrator RK4, and knows nothing of measures: there, whole steps are
differenced.

Centred differences `(f(x + w) - f(x - w)) / 2w` are exact to the order of w^2, forward ones
`(f(x + w) - f(x)) / w` to that of w, at half the cost. For an action on the edge of the box, the
difference is one-sided, inwards.
"""

from typing import Any, NamedTuple

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.engine import mujoco
from physics.mujoco.model import actuators_of
from physics.mujoco.simulation import Simulation
from physics.mujoco.tangent import from_coordinates, to_coordinates


class Differencing(NamedTuple):
    """The width and kind of differences."""

    width: float
    centred: bool


def has_transition_derivatives(model: Any) -> bool:
    """Whether the engine has `mjd_transitionFD` for the model's integrator."""
    return bool(model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4)


def by_the_engine(
    simulation: Simulation, state: FloatArray, action: FloatArray, how: Differencing
) -> tuple[FloatArray, FloatArray]:
    """The Jacobians [n, n] and [n, m] of one step, of a simulation without measures."""
    model, data = simulation.model, simulation.data
    size = 2 * model.nv + model.na
    A, B = np.eye(size), np.zeros((size, model.nu))
    of_state, of_control = np.empty((size, size)), np.empty((size, model.nu))
    simulation.load(state, action)
    for _ in range(simulation.substeps):
        mujoco.mjd_transitionFD(
            model, data, how.width, how.centred, of_state, of_control, None, None
        )
        A, B = of_state @ A, of_state @ B + of_control
        mujoco.mj_step(model, data)
    following = np.empty_like(state)
    simulation.read(following)
    G = to_coordinates(model, following)
    return G @ A @ from_coordinates(model, state), G @ B * actuators_of(model).half


def by_whole_steps(
    simulation: Simulation, state: FloatArray, action: FloatArray, how: Differencing
) -> tuple[FloatArray, FloatArray]:
    """The Jacobians [n, n] and [n, m] of one step; the columns of measures are 0."""
    model = simulation.model
    size, n = 2 * model.nv + model.na, len(state)
    columns = np.empty((size + model.nu, n))
    ahead, behind, centre = np.empty(n), np.empty(n), np.empty(n)
    simulation.advance(state, action, centre)
    for j in range(size):
        simulation.advance(simulation.moved(state, j, how.width), action, ahead)
        if how.centred:
            simulation.advance(simulation.moved(state, j, -how.width), action, behind)
            columns[j] = (ahead - behind) / (2.0 * how.width)
        else:
            columns[j] = (ahead - centre) / how.width
    for j in range(model.nu):
        high, low = action.copy(), action.copy()
        high[j] = min(action[j] + how.width, 1.0)
        if how.centred or high[j] == action[j]:
            low[j] = max(action[j] - how.width, -1.0)
        simulation.advance(state, high, ahead)
        simulation.advance(state, low, behind)
        columns[size + j] = (ahead - behind) / (high[j] - low[j])
    by_state = np.zeros((n, n))
    by_state[:, : simulation.coordinates] = columns[:size].T @ from_coordinates(
        model, state[: simulation.coordinates]
    )
    return by_state, columns[size:].T
