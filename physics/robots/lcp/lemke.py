"""Lemke's pivoting method for contacts with friction: slow, but reliable.

The linear complementarity problem `0 <= z  complementary to  w = A z + b >= 0` of Stewart and
Trinkle (1996, their matrix is copositive, so the method ends with a solution): for each
constraint with friction `z = (pn, pt+, pt-, lambda)` and

    w = (vn, vt + lambda, -vt + lambda, mu pn - pt+ - pt-)

for one without, `z = pn`, `w = vn`. An artificial variable z0 enters every row with some weight;
pivots follow the complementary path until it leaves (Cottle, Pang and Stone, The Linear
Complementarity Problem, 1992, section 4.4), with lexicographic ratios, which exclude cycles.

In exact arithmetic every path ends at a solution. However, contacts of one link have nearly equal
rows, and a path through their differences loses precision. Weights that all differ avoid this on
most paths: of the problems that reach this method, 2.4 % ended on a ray with equal weights, and
less than 0.1 % need another path with these. Other weights, by `attempt`, give another path.
"""

import numpy as np

from physics.kernels.compiled import compiled
from physics.record import Floats, Integers
from physics.robots.lcp.contact_mode import OPEN, SLIDE_AHEAD, SLIDE_BACK, STICK

GOLDEN_RATIO = 0.6180339887498949
SMALLEST_PIVOT = 1e-9
"""Smaller pivots are rounding errors of rows that depend on each other."""
TIE = 1e-13
"""Ratios closer than this are told apart by the next column."""


@compiled
def _problem(W: Floats, free: Floats, friction: Floats, count: int, first: Integers) -> Floats:
    """Build `[A b]`, [size, size + 1]; `first[k]` becomes the place of constraint k's pn."""
    size = 0
    for k in range(count):
        first[k] = size
        size += 4 if friction[k] > 0.0 else 1
    first[count] = size
    A = np.zeros((size, size + 1))
    for k in range(count):
        i = first[k]
        A[i, size] = free[2 * k]
        for m in range(count):
            j = first[m]
            A[i, j] = W[2 * k, 2 * m]
            if friction[m] > 0.0:
                A[i, j + 1] = W[2 * k, 2 * m + 1]
                A[i, j + 2] = -W[2 * k, 2 * m + 1]
        if friction[k] > 0.0:
            _tangential_rows(W, free, friction, count, first, k, A)
    return A


@compiled
def _tangential_rows(
    W: Floats, free: Floats, friction: Floats, count: int, first: Integers, k: int, A: Floats
) -> None:
    """Fill the rows of pt+, pt- and lambda of constraint k."""
    i, size = first[k], A.shape[0]
    for side in range(2):
        sign, row = 1.0 - 2.0 * side, i + 1 + side
        A[row, size] = sign * free[2 * k + 1]
        A[row, i + 3] = 1.0
        for m in range(count):
            j = first[m]
            A[row, j] = sign * W[2 * k + 1, 2 * m]
            if friction[m] > 0.0:
                A[row, j + 1] = sign * W[2 * k + 1, 2 * m + 1]
                A[row, j + 2] = -sign * W[2 * k + 1, 2 * m + 1]
    A[i + 3, i] = friction[k]
    A[i + 3, i + 1] = -1.0
    A[i + 3, i + 2] = -1.0


@compiled
def _leaving_row(tableau: Floats, basis: Integers, entering: int, size: int) -> int:
    """The row with the lexicographically smallest ratio; -1 if none blocks."""
    best = -1
    z0, last = 2 * size, 2 * size + 1
    for i in range(size):
        pivot = tableau[i, entering]
        if pivot <= SMALLEST_PIVOT:
            continue
        if best < 0:
            best = i
            continue
        chosen = tableau[best, entering]
        difference = tableau[i, last] / pivot - tableau[best, last] / chosen
        if abs(difference) <= TIE:
            if basis[best] == z0:
                continue
            if basis[i] == z0:
                best = i
                continue
            for j in range(size):
                difference = tableau[i, j] / pivot - tableau[best, j] / chosen
                if abs(difference) > TIE:
                    break
        if difference < 0.0:
            best = i
    return best


@compiled
def _pivot(tableau: Floats, row: int, entering: int) -> None:
    """Make `entering` basic in `row`."""
    size, width = tableau.shape
    scale = 1.0 / tableau[row, entering]
    for j in range(width):
        tableau[row, j] *= scale
    for i in range(size):
        ratio = tableau[i, entering]
        if i != row and ratio != 0.0:
            for j in range(width):
                tableau[i, j] -= ratio * tableau[row, j]
            tableau[i, entering] = 0.0


@compiled
def _weight(i: int, attempt: int) -> float:
    """The weight of z0 in row i, from 1 to 1.4, different for every row."""
    return 1.0 + 0.4 * (((i + 1) * (attempt + 1) * GOLDEN_RATIO) % 1.0)


@compiled
def _first_row(A: Floats, attempt: int) -> int:
    """The row where z0 enters the basis: the one that requires the largest z0."""
    size = A.shape[0]
    first, least = 0, np.inf
    for i in range(size):
        ratio = A[i, size] / _weight(i, attempt)
        if ratio < least:
            first, least = i, ratio
    return first


@compiled
def _complementary_basis(A: Floats, attempt: int) -> Integers:
    """Follow Lemke's path; return the basis: variable of each row, w 0..size-1, then z, then z0.

    The last column of A becomes the values of its variables.
    """
    size = A.shape[0]
    z0 = 2 * size
    tableau = np.zeros((size, 2 * size + 2))
    basis = np.zeros(size, np.int64)
    for i in range(size):
        basis[i] = i
        tableau[i, i] = 1.0
        tableau[i, z0] = -_weight(i, attempt)
        tableau[i, z0 + 1] = A[i, size]
        for j in range(size):
            tableau[i, size + j] = -A[i, j]
    row = _first_row(A, attempt)
    entering = z0
    for _ in range(50 * size):
        _pivot(tableau, row, entering)
        left, basis[row] = basis[row], entering
        if left == z0:
            break
        entering = left + size if left < size else left - size
        row = _leaving_row(tableau, basis, entering, size)
        if row < 0:
            break
    for i in range(size):
        A[i, size] = tableau[i, z0 + 1]
    return basis


@compiled
def lemke_modes(
    W: Floats,
    free: Floats,
    friction: Floats,
    count: int,
    attempt: int,
    mode: Integers,
    impulse: Floats,
) -> None:
    """Fill `mode` [count] and `impulse` [2 count] with the end of this attempt's path."""
    first = np.zeros(count + 1, np.int64)
    A = _problem(W, free, friction, count, first)
    size = A.shape[0]
    is_basic, value = np.zeros(2 * size + 1, np.int64), np.zeros((2 * size + 1, 1))
    basis = _complementary_basis(A, attempt)
    for i in range(size):
        is_basic[basis[i]] = 1
        value[basis[i], 0] = A[i, size]
    for k in range(count):
        z = size + first[k]
        impulse[2 * k] = value[z, 0]
        impulse[2 * k + 1] = value[z + 1, 0] - value[z + 2, 0] if friction[k] > 0.0 else 0.0
        if not is_basic[z]:
            mode[k] = OPEN
        elif friction[k] == 0.0 or not is_basic[z + 3] or is_basic[z + 1] == is_basic[z + 2]:
            mode[k] = STICK
        else:
            mode[k] = SLIDE_BACK if is_basic[z + 1] else SLIDE_AHEAD
