"""Box-constrained quadratic program, by projected Newton.

    x = argmin  x' H x / 2 + g' x     subject to  lower <= x <= upper

A coordinate is *clamped* where it sits on a bound and the gradient `q = H x + g` pushes it
outwards; the others are *free*. Each iteration projects the Newton step of the free ones,

    x_f  ->  clip(x_f - H_ff^-1 q_f)

on the box. If that does not decrease the objective enough (Armijo's rule), it takes the lowest
point of the projected path's first straight piece instead. At the solution the free gradient is 0;
then `H_ff^-1` also gives the response of the free coordinates to a change of g, which iLQR's
feedback needs.

Sources: Bertsekas (1982); Tassa, Mansard and Todorov (2014), section III. Differences from their
code: the first piece replaces steps of 0.6, 0.36, ..., which approach a bound but never reach it;
and a gradient counts as 0 by the rounding of its own terms, not below a fixed 1e-8.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from physics.kernels.compiled import compiled

Floats = NDArray[np.float64]

NOT_CONVEX = -1
"""The result of `solve` if `H_ff` is not positive definite."""

ITERATIONS = 100
ARMIJO = 0.1
ROUNDING = 1e-13


class BoxWork(NamedTuple):
    """Arrays of a program of m variables; after `solve` they describe its free coordinates."""

    free: NDArray[np.int64]
    """[m], the free coordinates come first."""
    factor: Floats
    """[m, m], lower Cholesky factor of `H_ff`, in the order of `free`."""
    gradient: Floats
    """[m], q."""
    move: Floats
    """[m], the difference of the trial from x."""
    newton: Floats
    """[m], the free coordinates' Newton step, in the order of `free`."""


def new_box_work(size: int) -> BoxWork:
    """Arrays for programs of `size` variables."""
    return BoxWork(
        np.empty(size, np.int64),
        np.empty((size, size)),
        np.empty(size),
        np.empty(size),
        np.empty(size),
    )


@compiled
def solve(H: Floats, g: Floats, lower: Floats, upper: Floats, x: Floats, work: BoxWork) -> int:
    """Solve in place, from the guess `x [m]`; return how many coordinates are free.

    Returns `NOT_CONVEX` for a free block without a Cholesky factor; x is then inside the box, but
    not a solution.
    """
    for i in range(x.size):
        x[i] = min(max(x[i], lower[i]), upper[i])
    free = 0
    for _ in range(ITERATIONS):
        free, is_solved = split(H, g, lower, upper, x, work)
        if not factorise(H, free, work):
            return NOT_CONVEX
        if is_solved:
            break
        for k in range(free):
            work.newton[k] = -work.gradient[work.free[k]]
        solve_free(free, work, work.newton)
        if not take_newton_step(H, lower, upper, x, free, work):
            take_first_piece(H, lower, upper, x, free, work)
    return free


@compiled
def split(
    H: Floats, g: Floats, lower: Floats, upper: Floats, x: Floats, work: BoxWork
) -> tuple[int, bool]:
    """Fill the gradient and list the free coordinates.

    Returns:
        The number of free coordinates, and whether all their gradients are 0.
    """
    free, is_solved = 0, True
    for i in range(x.size):
        slope, size = g[i], abs(g[i])
        for j in range(x.size):
            slope += H[i, j] * x[j]
            size += abs(H[i, j] * x[j])
        work.gradient[i] = slope
        is_clamped = (x[i] <= lower[i] and slope > 0) or (x[i] >= upper[i] and slope < 0)
        if not is_clamped:
            work.free[free] = i
            free += 1
            is_solved &= abs(slope) <= ROUNDING * size
    return free, is_solved


@compiled
def factorise(H: Floats, free: int, work: BoxWork) -> bool:
    """Fill the Cholesky factor of `H_ff`; False where it has none."""
    L = work.factor
    for i in range(free):
        for j in range(i + 1):
            total = H[work.free[i], work.free[j]]
            for k in range(j):
                total -= L[i, k] * L[j, k]
            if i > j:
                L[i, j] = total / L[j, j]
            elif total > 0 and np.isfinite(total):
                L[i, i] = np.sqrt(total)
            else:
                return False
    return True


@compiled
def solve_free(free: int, work: BoxWork, b: Floats) -> None:
    """Replace the first `free` entries of b by `H_ff^-1 b`."""
    L = work.factor
    for i in range(free):
        for k in range(i):
            b[i] -= L[i, k] * b[k]
        b[i] /= L[i, i]
    for i in range(free - 1, -1, -1):
        for k in range(i + 1, free):
            b[i] -= L[k, i] * b[k]
        b[i] /= L[i, i]


@compiled
def take_newton_step(
    H: Floats, lower: Floats, upper: Floats, x: Floats, free: int, work: BoxWork
) -> bool:
    """Move x by the projected Newton step, if that decreases the objective enough."""
    move = work.move
    move[:] = 0.0
    slope = 0.0
    for k in range(free):
        i = work.free[k]
        move[i] = min(max(x[i] + work.newton[k], lower[i]), upper[i]) - x[i]
        slope += work.gradient[i] * move[i]
    if slope + bend(H, move) / 2 > ARMIJO * slope or slope >= 0.0:
        return False
    for k in range(free):
        i = work.free[k]
        x[i] = min(max(x[i] + work.newton[k], lower[i]), upper[i])
    return True


@compiled
def take_first_piece(
    H: Floats, lower: Floats, upper: Floats, x: Floats, free: int, work: BoxWork
) -> None:
    """Move x along the Newton step to the lowest point before another coordinate is stopped."""
    move = work.move
    move[:] = 0.0
    slope, length, first = 0.0, np.inf, -1
    for k in range(free):
        i, way = work.free[k], work.newton[k]
        room = (upper[i] if way > 0.0 else lower[i]) - x[i]
        if way == 0.0 or room == 0.0:
            continue
        move[i] = way
        slope += work.gradient[i] * way
        if room / way < length:
            length, first = room / way, i
    lowest = -slope / bend(H, move) if slope < 0.0 else 0.0
    for k in range(free):
        i = work.free[k]
        x[i] = min(max(x[i] + min(lowest, length) * move[i], lower[i]), upper[i])
    if length <= lowest:
        x[first] = upper[first] if move[first] > 0.0 else lower[first]


@compiled
def bend(H: Floats, move: Floats) -> float:
    """`move' H move`."""
    total = 0.0
    for i in range(move.size):
        for j in range(move.size):
            total += move[i] * H[i, j] * move[j]
    return total
