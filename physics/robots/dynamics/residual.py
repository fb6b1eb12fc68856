"""The residual of a substep: the largest error of its equations, each in its own unit.

The errors are that of the equation of motion (N s, in relative angles, where the force on a joint
is the sum over the links beyond it), and `|min(x, y)|` for the complementary pairs of every
constraint, with `pt+ = max(pt, 0)`, `pt- = max(-pt, 0)`, `lambda = |Jt v'|`:

    pn, Jn v' + distance / h      pt+, lambda + Jt v'      pt-, lambda - Jt v'
    lambda, mu pn - pt+ - pt-
"""

from math import inf, isfinite

from physics.kernels.compiled import compiled
from physics.robots.dynamics.body import Body
from physics.robots.dynamics.constraints import approach
from physics.robots.dynamics.pose import ROOT
from physics.robots.model.mechanism import Mechanism

BOUND = 1e-8
"""A substep with a larger residual counts as unsolved; the usual one is below 1e-11."""


@compiled
def _motion_error(mechanism: Mechanism, body: Body) -> float:
    """Largest entry of `A (v' - v) - f - J^T p`."""
    n, parent, problem = mechanism.parent.shape[0], mechanism.parent, body.problem
    error = body.error
    for j in range(n):
        error[j] = -body.force[j]
        for row in range(2 * problem.count):
            error[j] -= body.J[row, j] * problem.impulse[row]
    for j in range(n):
        error[j] += body.A[j, j] * body.change[j]
        i = parent[j]
        while i >= 0:
            error[j] += body.A[j, i] * body.change[i]
            error[i] += body.A[j, i] * body.change[j]
            i = parent[i]
    largest = 0.0
    for j in range(n - 1, -1, -1):
        largest = max(largest, abs(error[j]))
        if j > ROOT:
            error[parent[j]] += error[j]
    return largest


@compiled
def _friction_error(body: Body, i: int) -> float:
    """The largest error of the pairs of candidate i that involve friction."""
    problem = body.problem
    pn, pt = problem.impulse[2 * i], problem.impulse[2 * i + 1]
    slip = 0.0
    for j in range(body.next_v.shape[0]):
        slip += body.J[2 * i + 1, j] * body.next_v[j]
    speed = abs(slip)
    forward = abs(min(max(pt, 0.0), speed + slip))
    backward = abs(min(max(-pt, 0.0), speed - slip))
    cone = abs(min(speed, problem.friction[i] * pn - abs(pt)))
    worst: float = max(forward, backward, cone)
    return worst


@compiled
def residual(mechanism: Mechanism, body: Body) -> float:
    """The largest error of a solved substep; infinity if its velocity or impulses are not finite.

    These are checked first, because `max` ignores a NaN.
    """
    problem = body.problem
    for j in range(body.next_v.shape[0]):
        if not isfinite(body.next_v[j]):
            return inf
    for row in range(2 * problem.count):
        if not isfinite(problem.impulse[row]):
            return inf
    largest: float = _motion_error(mechanism, body)
    for k in range(body.margin.shape[0]):
        rate = approach(mechanism, body.pose, body.next_v, k) + body.margin[k]
        largest = max(largest, -rate)
    for i in range(problem.count):
        k, pn = body.candidate[i], problem.impulse[2 * i]
        rate = approach(mechanism, body.pose, body.next_v, k) + body.margin[k]
        largest = max(largest, abs(min(pn, rate)))
        if problem.friction[i] > 0.0:
            largest = max(largest, _friction_error(body, i))
    return largest
