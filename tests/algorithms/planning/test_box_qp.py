"""The box-constrained quadratic program, against scipy's bounded-variable least squares."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from algorithms.planning.box_qp import NOT_CONVEX, Floats, new_box_work, solve, solve_free

PROBLEMS = 500


def random_program(rng: np.random.Generator, size: int) -> tuple[Floats, Floats, Floats, Floats]:
    """A square root A of H, and g, lower, upper; scales over four decades, 0 inside or outside."""
    A = rng.normal(size=(size + 2, size)) * 10.0 ** rng.uniform(-2, 2, size)
    g = rng.normal(size=size) * 10.0 ** rng.uniform(-2, 2)
    middle, half = rng.normal(size=size), 10.0 ** rng.uniform(-2, 1, size)
    return A, g, middle - half, middle + half


@pytest.mark.parametrize("size", [1, 2, 3, 4, 6, 8])
def test_it_equals_a_reference_on_thousands_of_random_programs(size: int) -> None:
    rng = np.random.default_rng(size)
    work = new_box_work(size)
    for _ in range(PROBLEMS):
        A, g, lower, upper = random_program(rng, size)
        # |A x - b|^2 / 2 with A' b = -g has the same minimum.
        b = np.linalg.lstsq(A.T, -g)[0]
        reference = lsq_linear(A, b, (lower, upper), method="bvls", tol=1e-15).x
        x = rng.normal(size=size)
        assert solve(A.T @ A, g, lower, upper, x, work) != NOT_CONVEX
        assert np.all((lower <= x) & (x <= upper))
        scale = np.abs(A).max(axis=0)
        np.testing.assert_allclose(x * scale, reference * scale, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("size", [1, 4, 8])
def test_the_solution_meets_the_optimality_conditions_to_rounding(size: int) -> None:
    rng = np.random.default_rng(100 + size)
    work = new_box_work(size)
    for _ in range(PROBLEMS):
        A, g, lower, upper = random_program(rng, size)
        H, x = A.T @ A, np.zeros(size)
        count = solve(H, g, lower, upper, x, work)
        gradient = H @ x + g
        free = np.isin(np.arange(size), work.free[:count])
        rounding = 1e-10 * (np.abs(H) @ np.abs(x) + np.abs(g))
        assert np.all(np.abs(gradient[free]) <= rounding[free])
        assert np.all((x == lower) | (x == upper) | free)
        assert np.all(gradient[~free & (x == lower)] > 0)
        assert np.all(gradient[~free & (x == upper)] < 0)


def test_the_guess_does_not_matter() -> None:
    rng = np.random.default_rng(7)
    work = new_box_work(4)
    for _ in range(PROBLEMS):
        A, g, lower, upper = random_program(rng, 4)
        solutions = []
        for guess in (lower.copy(), upper.copy(), rng.normal(size=4)):
            solve(A.T @ A, g, lower, upper, guess, work)
            solutions.append(guess * np.abs(A).max(axis=0))
        np.testing.assert_allclose(solutions[1:], [solutions[0]] * 2, rtol=1e-7, atol=1e-7)


def test_the_factor_solves_for_the_free_coordinates() -> None:
    H = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
    g = np.array([-1.0, 30.0, -1.0])
    work, x = new_box_work(3), np.zeros(3)
    count = solve(H, g, -np.ones(3), np.ones(3), x, work)
    assert count == 2
    assert work.free[:2].tolist() == [0, 2]
    answer = np.array([1.0, 2.0, 0.0])
    solve_free(count, work, answer)
    np.testing.assert_allclose(H[np.ix_([0, 2], [0, 2])] @ answer[:2], [1.0, 2.0])


def test_all_clamped_leaves_nothing_free() -> None:
    work, x = new_box_work(2), np.zeros(2)
    assert solve(np.eye(2), np.array([9.0, -9.0]), -np.ones(2), np.ones(2), x, work) == 0
    assert x.tolist() == [-1.0, 1.0]


@pytest.mark.parametrize(
    "H", [np.diag([1.0, -1.0]), np.zeros((2, 2)), np.full((2, 2), np.nan), np.diag([np.inf, 1.0])]
)
def test_what_is_not_convex_is_refused(H: Floats) -> None:
    work, x = new_box_work(2), np.zeros(2)
    assert solve(H, np.zeros(2), -np.ones(2), np.ones(2), x, work) == NOT_CONVEX
