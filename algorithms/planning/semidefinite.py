"""The nearest positive semi-definite matrix, by Jacobi's rotations.

    A = V diag(d) V'     ->     V diag(max(d, 0)) V'          (nearest in the Frobenius norm)

Jacobi's method skips entries that are already 0, as most are in the curvature of a reward.
Sources: Higham (1988); Golub and Van Loan (2013), algorithm 8.5.3.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from physics.kernels.compiled import compiled

Floats = NDArray[np.float64]

SWEEPS = 30
ROUNDING = 1e-15


@compiled
def make_semidefinite(A: Floats, D: Floats, V: Floats) -> None:
    """Replace the symmetric `A [k, k]` in place; `D, V [k, k]` are scratch."""
    k = A.shape[0]
    for i in range(k):
        for j in range(k):
            D[i, j] = A[i, j]
            V[i, j] = 1.0 if i == j else 0.0
    diagonalise(D, V)
    lowest = 0.0
    for i in range(k):
        lowest = min(lowest, D[i, i])
    if lowest >= 0.0:
        return
    A[:] = 0.0
    for e in range(k):
        if D[e, e] > 0.0:
            for i in range(k):
                for j in range(i + 1):
                    A[i, j] += D[e, e] * V[i, e] * V[j, e]
    for i in range(k):
        for j in range(i):
            A[j, i] = A[i, j]


@compiled
def diagonalise(D: Floats, V: Floats) -> None:
    """Rotate D to diagonal form, gathering the rotations in the columns of V."""
    k = D.shape[0]
    size = 0.0
    for p in range(k):
        for q in range(k):
            size = max(size, abs(D[p, q]))
    for _ in range(SWEEPS):
        is_diagonal = True
        for p in range(k):
            for q in range(p + 1, k):
                if abs(D[p, q]) > ROUNDING * size:
                    is_diagonal = False
                    rotate(D, V, p, q)
        if is_diagonal:
            return


@compiled
def rotate(D: Floats, V: Floats, p: int, q: int) -> None:
    """Turn the plane (p, q) so that `D[p, q]` becomes 0."""
    cosine, sine = rotation(D[p, p], D[p, q], D[q, q])
    for i in range(D.shape[0]):
        D[i, p], D[i, q] = cosine * D[i, p] - sine * D[i, q], sine * D[i, p] + cosine * D[i, q]
    for j in range(D.shape[0]):
        D[p, j], D[q, j] = cosine * D[p, j] - sine * D[q, j], sine * D[p, j] + cosine * D[q, j]
        V[j, p], V[j, q] = cosine * V[j, p] - sine * V[j, q], sine * V[j, p] + cosine * V[j, q]
    D[p, q] = D[q, p] = 0.0


@compiled
def rotation(a: float, b: float, d: float) -> Any:
    """Cosine and sine of the smaller angle that makes [[a, b], [b, d]] diagonal."""
    tau = (d - a) / (2.0 * b)
    tangent = 1.0 / (abs(tau) + np.sqrt(1.0 + tau * tau))
    if tau < 0.0:
        tangent = -tangent
    cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
    return cosine, tangent * cosine
