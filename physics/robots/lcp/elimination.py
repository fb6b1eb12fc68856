"""Gaussian elimination with complete pivoting, which finds the rank of a small system.

    G[rows][:, columns] = L U        L unit lower triangular, U upper, both stored in the place of G

Contacts of one rigid link can depend on each other: two sticking ones, or three normals. The system
then lacks full rank, any split of impulses among them is as good as any other, and the unknowns
without a pivot are set to 0. Pivoting is complete, because with partial pivoting a small pivot in
the wrong column counts towards the rank (found as Jacobians wrong by 14 %).

Golub and Van Loan, Matrix Computations (2013), section 3.4.
"""

from physics.kernels.compiled import compiled
from physics.record import Floats, Integers

RANK_TOLERANCE = 1e-12
"""Smaller fractions of the first pivot count as 0: dependent rows leave 1e-16, others 1e-5."""


@compiled
def _bring_pivot(G: Floats, rows: Integers, columns: Integers, step: int, size: int) -> float:
    """Swap the largest entry of the remaining block to its corner; return its magnitude."""
    row, column, largest = step, step, 0.0
    for i in range(step, size):
        for j in range(step, size):
            if abs(G[i, j]) > largest:
                row, column, largest = i, j, abs(G[i, j])
    if row != step:
        rows[step], rows[row] = rows[row], rows[step]
        for j in range(size):
            G[step, j], G[row, j] = G[row, j], G[step, j]
    if column != step:
        columns[step], columns[column] = columns[column], columns[step]
        for i in range(size):
            G[i, step], G[i, column] = G[i, column], G[i, step]
    return largest


@compiled
def factor(G: Floats, rows: Integers, columns: Integers, size: int) -> int:
    """Factor `G[:size, :size]` in place, fill the orders of rows and columns, return the rank."""
    smallest = 0.0
    for i in range(size):
        rows[i] = i
        columns[i] = i
    for s in range(size):
        largest = _bring_pivot(G, rows, columns, s, size)
        if s == 0:
            smallest = RANK_TOLERANCE * largest
        if not largest > smallest:
            return s
        for i in range(s + 1, size):
            G[i, s] /= G[s, s]
            for j in range(s + 1, size):
                G[i, j] -= G[i, s] * G[s, j]
    return size


@compiled
def substitute(
    G: Floats, rows: Integers, columns: Integers, rank: int, size: int, B: Floats, X: Floats
) -> None:
    """Solve `G X = B` for B [>= size, any] with the factor of G; B is overwritten."""
    for s in range(rank):
        for i in range(s):
            for j in range(B.shape[1]):
                B[rows[s], j] -= G[s, i] * B[rows[i], j]
    for s in range(rank - 1, -1, -1):
        for j in range(B.shape[1]):
            X[columns[s], j] = B[rows[s], j]
        for i in range(s + 1, rank):
            for j in range(B.shape[1]):
                X[columns[s], j] -= G[s, i] * X[columns[i], j]
        for j in range(B.shape[1]):
            X[columns[s], j] /= G[s, s]
    for s in range(rank, size):
        for j in range(B.shape[1]):
            X[columns[s], j] = 0.0
