"""Leaf-first factor: it is one, and it fills nothing in."""

import numpy as np

from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.dynamics.tree_factor import factor, to_leaves, to_root

PARENT = np.array([-1, 0, 1, 2, 3, 2, 5, 5])


def ancestors(j: int) -> list[int]:
    return [] if PARENT[j] < 0 else [int(PARENT[j]), *ancestors(int(PARENT[j]))]


def tree_matrix(random: np.random.Generator) -> FloatArray:
    """Positive definite: a sum of squares, each along one way to the root."""
    A = np.zeros((8, 8))
    for j in range(8):
        row = np.zeros(8)
        row[[j, *ancestors(j)]] = random.normal(size=1 + len(ancestors(j)))
        A += np.outer(row, row) + 0.1 * np.diag(np.eye(8)[j])
    return A


def test_the_factor_solves_and_keeps_the_trees_zeros() -> None:
    random = generator(0, "tree")
    for _ in range(20):
        A = tree_matrix(random)
        L, inverse, b = np.tril(A), np.empty(8), random.normal(size=8)
        factor(PARENT, L, inverse)
        x = b.copy()
        to_root(PARENT, L, x)
        x *= inverse
        to_leaves(PARENT, L, x)
        np.testing.assert_allclose(A @ x, b, rtol=1e-9, atol=1e-9)
        unit = np.tril(L, -1) + np.eye(8)
        np.testing.assert_allclose(
            unit.T @ np.diag(1.0 / inverse) @ unit, A, rtol=1e-12, atol=1e-12
        )
        for j in range(8):
            others = set(range(j)) - set(ancestors(j))
            assert not L[j, list(others)].any()
