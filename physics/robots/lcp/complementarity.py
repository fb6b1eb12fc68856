"""Contact impulses on their active set: a linear complementarity problem, solved directly.

Constraint k has a normal row 2k and, if its friction mu is positive, a tangential row 2k + 1:

    velocity = free + W impulse
    0 <= pn  complementary to  velocity[2k] >= 0
    |pt| <= mu pn, opposing velocity[2k + 1] (maximum dissipation)

W [2m, 2m] is the inverse inertia seen by the rows (Delassus operator), `free` the velocities
without impulses, including position terms.

Each constraint is in one of four modes (contact_mode.py), and given all modes the impulses follow
from linear equations. The modes are guessed, the equations solved, and each constraint that then
contradicts its mode changes it: one that penetrates sticks; a sticking one that pulls or leaves
the cone slides; a sliding one that pulls opens, that slips the other way sticks. Where this
cycles, Lemke's pivoting method (lemke.py) finds the modes.

Rows may depend on each other, such as those of two sticking contacts of one rigid link
(elimination.py). If all of a robot's joints are at their stops, this holds for contacts of
different links as well, and the split of impulses that the elimination finds may leave a cone where
another split does not. Then the split of Lemke's method is kept, and only corrected for rounding.
"""

from typing import Annotated, Protocol

from physics.kernels.compiled import compiled
from physics.record import Floats, Integers
from physics.robots.lcp.contact_mode import OPEN, SLIDE_AHEAD, SLIDE_BACK, STICK
from physics.robots.lcp.elimination import factor, substitute
from physics.robots.lcp.lemke import lemke_modes

UNSETTLED = -1
"""The result of `_next_mode` where there is a contradiction but no better mode."""
ROUNDS = 16
"""Guesses before Lemke's method takes over."""
ATTEMPTS = 8
"""Paths of Lemke's method: of 60,000 problems that needed it, 43 needed a second, 3 a third."""
SPLITS = 64
"""Paths whose split of impulses is tried where no modes settle: of some 30 million steps of the
evaluation on Walker2d, two needed the 17th and the 36th path."""
TOLERANCE = 1e-12
"""Contradictions below this, in units of the largest free velocity or 1, are rounding."""


class Complementarity(Protocol):
    """The problem of `count` constraints, at most k, its solution, and scratch."""

    count: int
    W: Annotated[Floats, "2 * k", "2 * k"]
    free: Annotated[Floats, "2 * k"]
    friction: Annotated[Floats, "k"]
    mode: Annotated[Integers, "k"]
    """Guess, then result."""
    impulse: Annotated[Floats, "2 * k"]
    velocity: Annotated[Floats, "2 * k"]
    unknowns: int
    """How many impulses are unknown."""
    rows: Annotated[Integers, "2 * k"]
    """Row of W of each unknown."""
    slope: Annotated[Floats, "2 * k"]
    """pt / pn of each unknown."""
    G: Annotated[Floats, "2 * k", "2 * k"]
    """Factor of the active system, [unknowns, unknowns] of it."""
    rank: int
    row_order: Annotated[Integers, "2 * k"]
    column_order: Annotated[Integers, "2 * k"]
    right: Annotated[Floats, "2 * k", "1"]
    unknown: Annotated[Floats, "2 * k", "1"]


@compiled
def _list_unknowns(problem: Complementarity) -> None:
    """List the impulses that the modes leave unknown, and the pt that comes with each pn.

    A sliding contact's impulse acts along `normal + slope tangent`.
    """
    size = 0
    for k in range(problem.count):
        mode, friction = problem.mode[k], problem.friction[k]
        if mode != OPEN:
            problem.rows[size] = 2 * k
            problem.slope[size] = 0.0
            if mode == SLIDE_AHEAD:
                problem.slope[size] = -friction
            elif mode == SLIDE_BACK:
                problem.slope[size] = friction
            elif friction > 0.0:
                size += 1
                problem.rows[size] = 2 * k + 1
                problem.slope[size] = 0.0
            size += 1
    problem.unknowns = size


@compiled
def _factor_active(problem: Complementarity) -> None:
    """Factor G: W between the active rows and the directions of their impulses."""
    for b in range(problem.unknowns):
        row, slope = problem.rows[b], problem.slope[b]
        for a in range(problem.unknowns):
            problem.G[a, b] = problem.W[problem.rows[a], row]
            if slope != 0.0:
                problem.G[a, b] += slope * problem.W[problem.rows[a], row + 1]
    problem.rank = factor(problem.G, problem.row_order, problem.column_order, problem.unknowns)


@compiled
def solve_active(problem: Complementarity, right: Floats, unknown: Floats) -> None:
    """Solve the active system for right sides [unknowns, any], which are overwritten."""
    substitute(
        problem.G,
        problem.row_order,
        problem.column_order,
        problem.rank,
        problem.unknowns,
        right,
        unknown,
    )


@compiled
def _solve_modes(problem: Complementarity) -> None:
    """Fill impulse and velocity for the modes, right or wrong."""
    _list_unknowns(problem)
    _factor_active(problem)
    for a in range(problem.unknowns):
        problem.right[a, 0] = -problem.free[problem.rows[a]]
    solve_active(problem, problem.right, problem.unknown)
    for r in range(2 * problem.count):
        problem.impulse[r] = 0.0
    for a in range(problem.unknowns):
        row, value = problem.rows[a], problem.unknown[a, 0]
        problem.impulse[row] = value
        if problem.slope[a] != 0.0:
            problem.impulse[row + 1] = problem.slope[a] * value
    _fill_velocity(problem)


@compiled
def _fill_velocity(problem: Complementarity) -> None:
    """Fill the velocities that the impulses lead to."""
    for r in range(2 * problem.count):
        problem.velocity[r] = problem.free[r]
    for b in range(2 * problem.count):
        impulse = problem.impulse[b]
        if impulse != 0.0:
            for a in range(2 * problem.count):
                problem.velocity[a] += problem.W[b, a] * impulse


@compiled
def _after_sticking(pn: float, pt: float, vt: float, friction: float, tolerance: float) -> int:
    """The next mode of a sticking contact: sliding if it pulls, leaves the cone, or slips.

    It can slip if its row depends on other rows, since only those are then kept at rest.
    """
    if pn < -tolerance or abs(pt) > friction * pn + tolerance:
        return SLIDE_BACK if pt > 0.0 else SLIDE_AHEAD
    if abs(vt) > tolerance:
        return SLIDE_AHEAD if vt > 0.0 else SLIDE_BACK
    return STICK


@compiled
def _after_sliding(pn: float, vt: float, mode: int, tolerance: float) -> int:
    """The next mode of a sliding contact: open if it pulls, sticking if it slips the other way."""
    if pn < -tolerance:
        return OPEN
    forward = vt if mode == SLIDE_AHEAD else -vt
    return STICK if forward < -tolerance else mode


@compiled
def _next_mode(problem: Complementarity, k: int, tolerance: float) -> int:
    """The mode of constraint k that fits the solution: its own, if there is no contradiction."""
    mode, friction = problem.mode[k], problem.friction[k]
    pn, pt = problem.impulse[2 * k], problem.impulse[2 * k + 1]
    vn, vt = problem.velocity[2 * k], problem.velocity[2 * k + 1]
    if mode == OPEN:
        return STICK if vn < -tolerance else OPEN
    if abs(vn) > tolerance:  # its row depends on others, which separate it or press it down
        return OPEN if vn > 0.0 else UNSETTLED
    if friction == 0.0:
        return OPEN if pn < -tolerance else STICK
    if mode == STICK:
        return _after_sticking(pn, pt, vt, friction, tolerance)
    return _after_sliding(pn, vt, mode, tolerance)


@compiled
def _settle(problem: Complementarity, tolerance: float) -> bool:
    """Solve and change modes until they agree; False if they cycle or there is no better mode."""
    for _ in range(ROUNDS):
        _solve_modes(problem)
        changes, is_lost = 0, False
        for k in range(problem.count):
            mode = _next_mode(problem, k, tolerance)
            changes += mode != problem.mode[k]
            if mode == UNSETTLED:
                is_lost = True
            else:
                problem.mode[k] = mode
        if changes == 0:
            return True
        if is_lost:
            return False
    return False


@compiled
def _correct(problem: Complementarity, tolerance: float) -> bool:
    """Correct the current impulses, and return whether the modes agree with them.

    The correction is of the size of rounding: where impulses can be split in many ways, the split
    remains.
    """
    _list_unknowns(problem)
    _factor_active(problem)
    _fill_velocity(problem)
    for a in range(problem.unknowns):
        problem.right[a, 0] = -problem.velocity[problem.rows[a]]
    solve_active(problem, problem.right, problem.unknown)
    for a in range(problem.unknowns):
        row = problem.rows[a]
        problem.impulse[row] += problem.unknown[a, 0]
        if problem.slope[a] != 0.0:
            problem.impulse[row + 1] = problem.slope[a] * problem.impulse[row]
    _fill_velocity(problem)
    changes = 0
    for k in range(problem.count):
        changes += _next_mode(problem, k, tolerance) != problem.mode[k]
    return changes == 0


@compiled
def _follow_lemke(problem: Complementarity, attempt: int) -> None:
    """Take modes and impulses from a path of Lemke's method."""
    lemke_modes(
        problem.W,
        problem.free,
        problem.friction,
        problem.count,
        attempt,
        problem.mode,
        problem.impulse,
    )


@compiled
def _search(problem: Complementarity, tolerance: float) -> None:
    """Find the modes by Lemke's method, where guessing fails."""
    for attempt in range(ATTEMPTS):
        _follow_lemke(problem, attempt)
        if _settle(problem, tolerance):
            return
    for attempt in range(SPLITS):
        _follow_lemke(problem, attempt)
        if _correct(problem, tolerance):
            return


@compiled
def solve(problem: Complementarity) -> None:
    """Find modes, impulses and velocities; `mode` holds a guess on entry."""
    largest = 1.0
    for r in range(2 * problem.count):
        largest = max(largest, abs(problem.free[r]))
    if not _settle(problem, TOLERANCE * largest):
        _search(problem, TOLERANCE * largest)
