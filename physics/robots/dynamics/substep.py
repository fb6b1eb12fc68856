"""One substep of a planar robot on flat ground: implicit springs and dampers, hard contact.

Stewart and Trinkle's time stepping (1996), for the step h, in the coordinates of pose.py:

    (M + h D + h^2 K) v' = M v + h (G a - K q - c(q, v)) + Jn^T pn + Jt^T pt + Jl^T pl
    0 <= pn  complementary to  Jn v' + gap / h >= 0          every sphere against the ground
    |pt| <= mu pn, opposing Jt v' (maximum dissipation)
    0 <= pl  complementary to  Jl v' + room / h >= 0         every stop of a joint
    q' = q + h v'

With `A = M + h D + h^2 K` (armature in M) the first line is solved for the change of velocity:
`A (v' - v) = f + J^T p`, `f = h (G a - K q - c) - (h D + h^2 K) v`.

Only the constraints that the motion would violate, the candidates, enter the linear
complementarity problem; all constraints are checked again after each solve.
"""

from physics.kernels.compiled import compiled
from physics.robots.dynamics.body import Body
from physics.robots.dynamics.constraints import approach, fill_rows, measure
from physics.robots.dynamics.pose import ROOT, bias, place
from physics.robots.dynamics.tree_factor import factor, to_leaves, to_root
from physics.robots.lcp.complementarity import TOLERANCE, solve
from physics.robots.lcp.contact_mode import STICK
from physics.robots.model.mechanism import Mechanism


@compiled
def _fill_inertia(mechanism: Mechanism, h: float, body: Body) -> None:
    """Fill A = M + armature + h D + h^2 K, and its factor."""
    n = mechanism.parent.shape[0]
    for j in range(n):
        for i in range(j + 1):
            body.A[j, i] = body.pose.M[j, i]
    for j in range(ROOT + 1, n):
        p = mechanism.parent[j]
        inertia = mechanism.armature[j] + h * (mechanism.damping[j] + h * mechanism.stiffness[j])
        body.A[j, j] += inertia
        body.A[p, p] += inertia
        body.A[j, p] -= inertia
    for j in range(n):
        for i in range(j + 1):
            body.L[j, i] = body.A[j, i]
    factor(mechanism.parent, body.L, body.inverse)


@compiled
def _fill_force(mechanism: Mechanism, h: float, body: Body) -> None:
    """Fill f."""
    bias(mechanism, body.pose, body.v, body.force)
    for j in range(mechanism.parent.shape[0]):
        body.force[j] *= -h
    for j in range(ROOT + 1, mechanism.parent.shape[0]):
        p, stiffness = mechanism.parent[j], mechanism.stiffness[j]
        drag = h * (mechanism.damping[j] + h * stiffness)
        push = h * (body.torque[j] - stiffness * (body.q[j] - body.q[p]))
        push -= drag * (body.v[j] - body.v[p])
        body.force[j] += push
        body.force[p] -= push


@compiled
def _change_velocity(mechanism: Mechanism, body: Body) -> None:
    """Solve `A change = f + J^T p` and fill `next_v`."""
    n, problem, parent = mechanism.parent.shape[0], body.problem, mechanism.parent
    for i in range(n):
        body.change[i] = body.force[i]
    for row in range(2 * problem.count):
        impulse = problem.impulse[row]
        if impulse != 0.0:
            for i in range(n):
                body.change[i] += body.J[row, i] * impulse
    to_root(parent, body.L, body.change)
    for i in range(n):
        body.change[i] *= body.inverse[i]
    to_leaves(parent, body.L, body.change)
    for i in range(n):
        body.next_v[i] = body.v[i] + body.change[i]


@compiled
def _add_candidate(mechanism: Mechanism, body: Body, k: int) -> None:
    """Append constraint k to the complementarity problem, sticking."""
    problem, n = body.problem, mechanism.parent.shape[0]
    first = 2 * problem.count
    body.candidate[problem.count] = k
    problem.friction[problem.count] = (
        mechanism.friction[k] if k < mechanism.radius.shape[0] else 0.0
    )
    problem.mode[problem.count] = STICK
    problem.count += 1
    fill_rows(mechanism, body.pose, k, body.J, first)
    for row in range(first, first + 2):
        free = body.margin[k] if row == first else 0.0
        for i in range(n):
            free += body.J[row, i] * body.free_v[i]
            body.Y[row, i] = body.J[row, i]
        problem.free[row] = free
        to_root(mechanism.parent, body.L, body.Y[row])
        for other in range(row + 1):
            inner = 0.0
            for i in range(n):
                inner += body.Y[row, i] * body.inverse[i] * body.Y[other, i]
            problem.W[row, other] = inner
            problem.W[other, row] = inner


@compiled
def _add_violated(mechanism: Mechanism, body: Body) -> bool:
    """Append the violated constraints that the problem lacks; False if there are none."""
    known = body.problem.count
    for k in range(body.margin.shape[0]):
        rate = approach(mechanism, body.pose, body.next_v, k)
        if rate + body.margin[k] < -TOLERANCE:
            is_new = True
            for i in range(known):
                is_new = is_new and body.candidate[i] != k
            if is_new:
                _add_candidate(mechanism, body, k)
    return body.problem.count > known


@compiled
def solve_substep(mechanism: Mechanism, h: float, body: Body) -> None:
    """Find the velocity after h, and the impulses."""
    place(mechanism, body.q, body.pose)
    measure(mechanism, body.q, body.pose, body.margin)
    for k in range(body.margin.shape[0]):
        body.margin[k] /= h
    _fill_inertia(mechanism, h, body)
    _fill_force(mechanism, h, body)
    body.problem.count = 0
    _change_velocity(mechanism, body)
    for i in range(body.v.shape[0]):
        body.free_v[i] = body.next_v[i]
    while _add_violated(mechanism, body):
        solve(body.problem)
        _change_velocity(mechanism, body)


@compiled
def advance(body: Body, h: float) -> None:
    """Advance the body to the end of the substep."""
    for i in range(body.v.shape[0]):
        body.v[i] = body.next_v[i]
        body.q[i] += h * body.v[i]
