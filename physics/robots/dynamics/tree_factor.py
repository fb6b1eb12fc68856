"""Leaf-first factorisation of a matrix with the sparsity of a tree: `A = L^T D L`.

`A[i, j]` is nonzero only where one index is an ancestor of the other, so that eliminating the
leaves first causes no fill-in between branches (Featherstone, Rigid Body Dynamics Algorithms,
2008, section 6.5). Only `A[j, i]` with `i` an ancestor of `j`, or `i = j`, is read or written.

    parent   [n] the next index towards the root, -1 at the root; parents precede children
    L        [n, n] unit lower triangular, stored in the place of A
    inverse  [n] 1 / D
"""

from physics.kernels.compiled import compiled
from physics.record import Floats, Integers


@compiled
def factor(parent: Integers, A: Floats, inverse: Floats) -> None:
    """Replace A by L and fill `inverse`."""
    for k in range(parent.shape[0] - 1, -1, -1):
        inverse[k] = 1.0 / A[k, k]
        i = parent[k]
        while i >= 0:
            ratio = A[k, i] * inverse[k]
            j = i
            while j >= 0:
                A[i, j] -= ratio * A[k, j]
                j = parent[j]
            A[k, i] = ratio
            i = parent[i]


@compiled
def to_root(parent: Integers, L: Floats, x: Floats) -> None:
    """Solve `L^T y = x` in place, x [n]."""
    for k in range(parent.shape[0] - 1, -1, -1):
        i = parent[k]
        while i >= 0:
            x[i] -= L[k, i] * x[k]
            i = parent[i]


@compiled
def to_leaves(parent: Integers, L: Floats, x: Floats) -> None:
    """Solve `L y = x` in place, x [n]."""
    for k in range(parent.shape[0]):
        i = parent[k]
        while i >= 0:
            x[k] -= L[k, i] * x[i]
            i = parent[i]
