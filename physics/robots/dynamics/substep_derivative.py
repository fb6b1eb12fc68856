"""The exact derivative of one substep, by the implicit function theorem on the solved system.

On the active set, with R the rows that hold with equality and C the directions in which their
impulses act (`R = C` but for a sliding contact, whose row is Jn and whose impulse acts along
`Jn + slope Jt`: friction makes the system unsymmetric, and it is C that is transposed below)

    A(q) (v' - v) = f(q, v, a) + C(q)^T p            R(q) v' + distance(q) / h = 0

both sides are differentiated along tangents (dq, dv, da), given as columns:

    A dv' = F + C^T dp        F = (M + armature) dv - h c_v dv + P dq + h G da
    R dv' = B                 B = -(R / h) dq - d(R) v'
    P dq  = -(dM) (v' - v) - h c_q dq - h K dq + d(C)^T p

and solved as `G dp = B - R A^-1 F`, `G = R A^-1 C^T`, `dv' = A^-1 (F + C^T dp)`. Rows of G that
depend on others (two sticking contacts of one link) are dropped by rank (elimination.py): `dv'` is
unique without them. The step `q' = q + h v'` is then `dq' = dq + h dv'`.

Where a constraint holds with no impulse (a kink), the derivative is that of the side the solver
chose: the mode in which it left the constraint.
"""

from typing import Annotated, Protocol

from physics.kernels.compiled import compiled
from physics.record import Floats
from physics.robots.dynamics.body import Body
from physics.robots.dynamics.pose import ROOT
from physics.robots.lcp.complementarity import solve_active
from physics.robots.model.mechanism import Mechanism


class Tangent(Protocol):
    """Derivatives of a body's q and v in p inputs (the start state, the action), and scratch."""

    inputs: int
    """p. If the compiler knew this number, it would unroll the loops over columns instead of
    vectorising them, and the derivative would take a sixth more time."""
    q: Annotated[Floats, "n", "p"]
    v: Annotated[Floats, "n", "p"]
    torque: Annotated[Floats, "n"]
    """d torque / d action of the joint's motor; 0 where the action is clipped."""
    P: Annotated[Floats, "n", "n"]
    V: Annotated[Floats, "n", "n"]
    """M + armature - h c_v."""
    F: Annotated[Floats, "n", "p"]
    """F, then dv'."""
    B: Annotated[Floats, "2 * k", "p"]
    dp: Annotated[Floats, "2 * k", "p"]


@compiled
def load_tangent(mechanism: Mechanism, actions: Floats, row: int, tangent: Tangent) -> None:
    """Set the derivatives of what `body.load_...` loads in the state and action of a row."""
    n = mechanism.parent.shape[0]
    tangent.inputs = tangent.q.shape[1]
    for j in range(n):
        tangent.torque[j] = 0.0
        for input_ in range(tangent.q.shape[1]):
            tangent.q[j, input_] = 0.0
            tangent.v[j, input_] = 0.0
        tangent.q[j, j] = mechanism.axis[j]
        tangent.v[j, n + j] = mechanism.axis[j]
        i = mechanism.parent[j]
        while i >= ROOT:
            tangent.q[j, i] = mechanism.axis[i]
            tangent.v[j, n + i] = mechanism.axis[i]
            i = mechanism.parent[i]
    for m in range(mechanism.motor.shape[0]):
        j = mechanism.motor[m]
        tangent.torque[j] = mechanism.gear[j] if abs(actions[row, m]) <= 1.0 else 0.0


@compiled
def unload_tangent(
    mechanism: Mechanism,
    tangent: Tangent,
    state_jacobians: Floats,
    action_jacobians: Floats,
    row: int,
) -> None:
    """Write the Jacobians of a row, in relative angles."""
    n, m = mechanism.parent.shape[0], mechanism.motor.shape[0]
    for j in range(n):
        p = mechanism.parent[j]
        for i in range(2 * n + m):
            dq, dv = tangent.q[j, i], tangent.v[j, i]
            if j > ROOT:
                dq = mechanism.axis[j] * (dq - tangent.q[p, i])
                dv = mechanism.axis[j] * (dv - tangent.v[p, i])
            if i < 2 * n:
                state_jacobians[row, j, i] = dq
                state_jacobians[row, n + j, i] = dv
            else:
                action_jacobians[row, j, i - 2 * n] = dq
                action_jacobians[row, n + j, i - 2 * n] = dv


@compiled
def _differentiate_motion(mechanism: Mechanism, h: float, body: Body, tangent: Tangent) -> None:
    """Fill P and V but for the joints and contacts (equations in pose.py)."""
    parent, n, pose, v, dv = mechanism.parent, body.v.shape[0], body.pose, body.v, body.change
    P, V = tangent.P, tangent.V
    for j in range(n):
        for i in range(n):
            P[j, i] = 0.0
            V[j, i] = 0.0
    V[0, 0] = mechanism.mass
    V[1, 1] = mechanism.mass
    for j in range(ROOT, n):
        x, z, square = pose.moment[j, 0], pose.moment[j, 1], h * v[j] * v[j]
        P[0, j] = x * dv[j] + square * z
        P[1, j] = z * dv[j] - square * x
        P[j, j] += x * dv[0] + z * (dv[1] + h * mechanism.gravity)
        V[0, j] = z + 2.0 * h * v[j] * x
        V[1, j] = -x + 2.0 * h * v[j] * z
        V[j, 0] = z
        V[j, 1] = -x
        V[j, j] += mechanism.inertia[j]
        i = parent[j]
        while i >= ROOT:
            M, N = pose.M[j, i], pose.N[j, i]
            outer = N * dv[j] + square * M
            inner = N * dv[i] - h * v[i] * v[i] * M
            P[i, i] -= outer
            P[i, j] += outer
            P[j, i] -= inner
            P[j, j] += inner
            V[i, j] += M + 2.0 * h * v[j] * N
            V[j, i] += M - 2.0 * h * v[i] * N
            i = parent[i]


@compiled
def _differentiate_joints(mechanism: Mechanism, h: float, tangent: Tangent) -> None:
    """Add springs to P and rotors to V."""
    P, V = tangent.P, tangent.V
    for j in range(ROOT + 1, mechanism.parent.shape[0]):
        p, spring = mechanism.parent[j], h * mechanism.stiffness[j]
        P[j, j] -= spring
        P[p, p] -= spring
        P[j, p] += spring
        P[p, j] += spring
        rotor = mechanism.armature[j]
        V[j, j] += rotor
        V[p, p] += rotor
        V[j, p] -= rotor
        V[p, j] -= rotor


@compiled
def _turn_of_row(mechanism: Mechanism, body: Body, row: int, j: int) -> float:
    """`d J[row, j] / d theta_j`, j an angle (constraints.py)."""
    k = body.candidate[row // 2]
    if k >= mechanism.radius.shape[0]:
        return 0.0
    turn: float = body.J[row - 1, j] if row % 2 == 1 else -body.J[row + 1, j]
    if row % 2 == 0 and mechanism.sphere_link[k] == j:
        turn -= mechanism.radius[k]
    return turn


@compiled
def _differentiate_impulses(mechanism: Mechanism, body: Body, tangent: Tangent) -> None:
    """Add the turning of the impulses' directions, which is diagonal, to P."""
    for row in range(2 * body.problem.count):
        impulse = body.problem.impulse[row]
        if impulse != 0.0:
            for j in range(ROOT, body.v.shape[0]):
                tangent.P[j, j] += _turn_of_row(mechanism, body, row, j) * impulse


@compiled
def _fill_right_side(mechanism: Mechanism, h: float, body: Body, tangent: Tangent) -> None:
    """Fill F."""
    n, inputs = body.v.shape[0], tangent.inputs
    F = tangent.F
    for i in range(n):
        for column in range(inputs):
            F[i, column] = 0.0
        for j in range(n):
            by_q, by_v = tangent.P[i, j], tangent.V[i, j]
            if by_q != 0.0 or by_v != 0.0:
                for column in range(inputs):
                    F[i, column] += by_q * tangent.q[j, column] + by_v * tangent.v[j, column]
    for m in range(mechanism.motor.shape[0]):
        j, column = mechanism.motor[m], 2 * n + m
        F[j, column] += h * tangent.torque[j]
        F[mechanism.parent[j], column] -= h * tangent.torque[j]


@compiled
def _fill_active_rows(mechanism: Mechanism, h: float, body: Body, tangent: Tangent) -> None:
    """Fill B - R A^-1 F, with `L^-T F` in the place of F."""
    problem, n, inputs = body.problem, body.v.shape[0], tangent.inputs
    for a in range(problem.unknowns):
        row = problem.rows[a]
        for column in range(inputs):
            tangent.B[a, column] = 0.0
        for j in range(n):
            slope = body.J[row, j] / h if row % 2 == 0 else 0.0
            if j >= ROOT:
                slope += _turn_of_row(mechanism, body, row, j) * body.next_v[j]
            weight = body.Y[row, j] * body.inverse[j]
            for column in range(inputs):
                tangent.B[a, column] -= slope * tangent.q[j, column] + weight * tangent.F[j, column]


@compiled
def _respond(mechanism: Mechanism, h: float, body: Body, tangent: Tangent) -> None:
    """Solve for the impulses' tangents and add their effect to `L^-T F`."""
    problem, inputs = body.problem, tangent.inputs
    _fill_active_rows(mechanism, h, body, tangent)
    solve_active(problem, tangent.B, tangent.dp)
    for a in range(problem.unknowns):
        row, slope = problem.rows[a], problem.slope[a]
        for j in range(body.v.shape[0]):
            push = body.Y[row, j]
            if slope != 0.0:
                push += slope * body.Y[row + 1, j]
            if push != 0.0:
                for column in range(inputs):
                    tangent.F[j, column] += push * tangent.dp[a, column]


@compiled
def differentiate_substep(mechanism: Mechanism, h: float, body: Body, tangent: Tangent) -> None:
    """Carry the tangent over a substep that `solve_substep` has solved and not yet advanced."""
    parent, n, inputs, F = mechanism.parent, body.v.shape[0], tangent.inputs, tangent.F
    _differentiate_motion(mechanism, h, body, tangent)
    _differentiate_joints(mechanism, h, tangent)
    _differentiate_impulses(mechanism, body, tangent)
    _fill_right_side(mechanism, h, body, tangent)
    for k in range(n - 1, -1, -1):
        i = parent[k]
        while i >= 0:
            for column in range(inputs):
                F[i, column] -= body.L[k, i] * F[k, column]
            i = parent[i]
    if body.problem.count > 0:
        _respond(mechanism, h, body, tangent)
    for k in range(n):
        for column in range(inputs):
            F[k, column] *= body.inverse[k]
        i = parent[k]
        while i >= 0:
            for column in range(inputs):
                F[k, column] -= body.L[k, i] * F[i, column]
            i = parent[i]
        for column in range(inputs):
            tangent.v[k, column] = F[k, column]
            tangent.q[k, column] += h * F[k, column]
