"""A robot's step: substeps under one action, with derivatives and contact modes on request.

One kernel does all of it. It is compiled once for the sizes of a robot, not for its numbers or its
callers.
"""

import numpy as np
import numpy.typing as npt

from physics.kernels.compiled import compiled
from physics.record import Floats, Records
from physics.robots.dynamics.body import Body, load_action, load_state, unload
from physics.robots.dynamics.residual import BOUND, residual
from physics.robots.dynamics.substep import advance, solve_substep
from physics.robots.dynamics.substep_derivative import (
    differentiate_substep,
    load_tangent,
    unload_tangent,
)
from physics.robots.model.mechanism import Mechanism

Modes = npt.NDArray[np.int8]


@compiled
def _record_modes(body: Body, modes: Modes, row: int, substep: int) -> None:
    """Fill in the mode of every constraint that a solved substep considered."""
    for i in range(body.problem.count):
        modes[row, substep, body.candidate[i]] = body.problem.mode[i]


@compiled
def move_rows(
    mechanisms: Records,
    no_bodies: Records,
    no_tangents: Records,
    h: float,
    substeps: int,
    states: Floats,
    actions: Floats,
    next_states: Floats,
    state_jacobians: Floats,
    action_jacobians: Floats,
    modes: Modes,
) -> int:
    """Step every row; return -1, or the first row that has no solution.

    Args:
        mechanisms: the robot [1].
        no_bodies: an array [0] of the type of its bodies.
        no_tangents: an array [0] of the type of its tangents.
        h: length of a substep (s).
        substeps: their number in a step.
        states: [batch, 2n].
        actions: [batch, m].
        next_states: [batch, 2n], filled.
        state_jacobians: [batch, 2n, 2n], filled; [0, 2n, 2n] for a step without derivatives.
        action_jacobians: [batch, 2n, m], filled with the others.
        modes: [batch, substeps, any], all OPEN, filled with the mode of constraint k at k;
            [0, substeps, any] for a step that is not recorded.
    """
    mechanism: Mechanism = mechanisms[0]
    bodies, tangents = np.empty(1, no_bodies.dtype), np.empty(1, no_tangents.dtype)
    is_differentiated, is_recorded = state_jacobians.shape[0] > 0, modes.shape[0] > 0
    for row in range(states.shape[0]):
        body, tangent = bodies[0], tangents[0]  # indexed in the loop, which keeps the arrays alive
        load_state(mechanism, states, row, body)
        load_action(mechanism, actions, row, body)
        if is_differentiated:
            load_tangent(mechanism, actions, row, tangent)
        for substep in range(substeps):
            solve_substep(mechanism, h, body)
            if not residual(mechanism, body) <= BOUND:
                return row
            if is_differentiated:
                differentiate_substep(mechanism, h, body, tangent)
            if is_recorded:
                _record_modes(body, modes, row, substep)
            advance(body, h)
        unload(mechanism, body, next_states, row)
        if is_differentiated:
            unload_tangent(mechanism, tangent, state_jacobians, action_jacobians, row)
    return -1
