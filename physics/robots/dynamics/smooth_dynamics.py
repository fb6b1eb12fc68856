"""Mass matrix and smooth forces of a robot in its own, relative angles: `M q'' = forces`.

With S the constant map from relative to absolute angles (body.py), `M = S^T M_absolute S` plus the
rotors, and a force on a relative angle is the sum over all links beyond the joint. The simulator
itself never needs these quantities: they serve to compare it with others.
"""

from physics.kernels.compiled import compiled
from physics.record import Floats, Records
from physics.robots.dynamics.body import Body, load_action, load_state
from physics.robots.dynamics.pose import ROOT, bias, place
from physics.robots.model.mechanism import Mechanism


@compiled
def _momentum(body: Body, v: Floats, momentum: Floats) -> None:
    """Fill `momentum` with M v, in absolute angles, without rotors."""
    for j in range(v.shape[0]):
        momentum[j] = 0.0
        for i in range(j + 1):
            momentum[j] += body.A[j, i] * v[i]
            if i < j:
                momentum[i] += body.A[j, i] * v[j]


@compiled
def _sum_beyond(mechanism: Mechanism, force: Floats) -> None:
    """Turn forces on absolute angles into those on relative ones."""
    for j in range(force.shape[0] - 1, ROOT, -1):
        force[mechanism.parent[j]] += force[j]


@compiled
def _fill_absolute(mechanism: Mechanism, body: Body) -> None:
    """Fill A with the whole lower triangle of M, zeros between branches."""
    for j in range(body.A.shape[0]):
        for i in range(j + 1):
            body.A[j, i] = 0.0
        body.A[j, j] = body.pose.M[j, j]
        i = mechanism.parent[j]
        while i >= 0:
            body.A[j, i] = body.pose.M[j, i]
            i = mechanism.parent[i]


@compiled
def mass_matrices(mechanisms: Records, bodies: Records, states: Floats, matrices: Floats) -> None:
    """Fill matrices [batch, n, n] for states [batch, 2n]."""
    mechanism, body = mechanisms[0], bodies[0]
    n = matrices.shape[1]
    for row in range(states.shape[0]):
        load_state(mechanism, states, row, body)
        place(mechanism, body.q, body.pose)
        _fill_absolute(mechanism, body)
        for i in range(n):
            for j in range(n):
                # S's column i: a unit turn of joint i turns all links beyond it
                inherits = j > ROOT and i >= ROOT and body.v[mechanism.parent[j]] == 1.0
                body.v[j] = 1.0 if j == i or inherits else 0.0
            _momentum(body, body.v, body.force)
            _sum_beyond(mechanism, body.force)
            for j in range(n):
                matrices[row, j, i] = mechanism.axis[j] * mechanism.axis[i] * body.force[j]
            matrices[row, i, i] += mechanism.armature[i]


@compiled
def smooth_forces(
    mechanisms: Records, bodies: Records, states: Floats, actions: Floats, forces: Floats
) -> None:
    """Fill forces [batch, n]: motors, springs, dampers, gravity and Coriolis forces (N, N m)."""
    mechanism, body = mechanisms[0], bodies[0]
    n = forces.shape[1]
    for row in range(states.shape[0]):
        load_state(mechanism, states, row, body)
        load_action(mechanism, actions, row, body)
        place(mechanism, body.q, body.pose)
        bias(mechanism, body.pose, body.v, body.force)
        _sum_beyond(mechanism, body.force)
        for j in range(n):
            spring = mechanism.stiffness[j] * states[row, j]
            damper = mechanism.damping[j] * states[row, n + j]
            axis = mechanism.axis[j]
            forces[row, j] = axis * body.torque[j] - spring - damper - axis * body.force[j]
