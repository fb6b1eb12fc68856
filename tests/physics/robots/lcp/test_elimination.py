"""Complete pivoting: the right solution, the right rank."""

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.lcp.elimination import factor, substitute


def solve(G: FloatArray, B: FloatArray) -> tuple[FloatArray, int]:
    size = len(G)
    work, right, unknown = G.copy(), B.copy(), np.full_like(B, np.nan)
    rows, columns = np.zeros(size, np.int64), np.zeros(size, np.int64)
    rank = factor(work, rows, columns, size)
    substitute(work, rows, columns, rank, size, right, unknown)
    return unknown, rank


@pytest.mark.parametrize("size", [1, 2, 5, 9])
def test_a_regular_system_is_solved(size: int) -> None:
    random = generator(size, "elimination")
    for _ in range(50):
        G, X = random.normal(size=(size, size)), random.normal(size=(size, 3))
        solved, rank = solve(G, G @ X)
        assert rank == size
        np.testing.assert_allclose(solved, X, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("rank", [0, 1, 3, 5])
def test_dependent_rows_are_found_and_a_solution_nevertheless(rank: int) -> None:
    random = generator(rank, "dependent")
    for _ in range(50):
        G = random.normal(size=(6, rank)) @ random.normal(size=(rank, 6))
        B = G @ random.normal(size=(6, 2))
        solved, found = solve(G, B)
        assert found == rank
        np.testing.assert_allclose(G @ solved, B, atol=1e-9)
        assert ((solved == 0.0).sum(axis=0) == 6 - rank).all()


def test_a_small_pivot_in_the_first_column_is_not_taken_for_rank() -> None:
    """Pivoting by rows alone meets 1e-14 first, calls it 0, and loses an equation."""
    G = np.array([[1e-14, 1.0, 0.0], [0.0, 1e-14, 1.0], [0.0, 0.0, 1e-3]])
    exact = np.array([[0.0], [2.0], [3.0]])
    solved, rank = solve(G, G @ exact)
    assert rank == 2  # 1e-14 against 1: one unknown cannot be told
    np.testing.assert_allclose(G @ solved, G @ exact, atol=1e-13)
