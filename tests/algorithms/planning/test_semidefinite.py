"""The nearest positive semi-definite matrix, against LAPACK's eigenvalues."""

import numpy as np
import pytest

from algorithms.planning.semidefinite import Floats, make_semidefinite


def nearest(A: Floats) -> Floats:
    values, vectors = np.linalg.eigh(A)
    result: Floats = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return result


@pytest.mark.parametrize("size", [1, 2, 5, 18])
def test_it_equals_clipped_eigenvalues(size: int) -> None:
    rng = np.random.default_rng(size)
    for _ in range(50):
        scales = 10.0 ** rng.uniform(-3, 3, size)
        A = rng.normal(size=(size, size)) * scales * scales[:, None]
        A = A + A.T
        expected, size_of_a = nearest(A), np.abs(A).max()
        make_semidefinite(A, np.empty_like(A), np.empty_like(A))
        np.testing.assert_allclose(A, expected, rtol=0, atol=1e-13 * size_of_a)


def test_what_is_semidefinite_stays_as_it_is() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        root = rng.normal(size=(6, 8))
        A = root @ root.T
        A = (A + A.T) / 2
        before = A.copy()
        make_semidefinite(A, np.empty_like(A), np.empty_like(A))
        assert np.array_equal(A, before)


def test_nothing_is_nothing() -> None:
    A = np.zeros((0, 0))
    make_semidefinite(A, A.copy(), A.copy())


def test_only_the_concave_part_is_taken_away() -> None:
    A = np.diag([2.0, -3.0, 0.0])
    make_semidefinite(A, np.empty_like(A), np.empty_like(A))
    assert np.array_equal(A, np.diag([2.0, 0.0, 0.0]))
