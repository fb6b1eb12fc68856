"""A product of Jacobians of a linear system is its power."""

import numpy as np
import pytest

from algorithms.diagnostics.closed_loop import roll_out
from algorithms.diagnostics.growth import WINDOWS, closed_loop_jacobians, product_norms
from tests.algorithms.diagnostics.test_smoothing import GAIN, linear, states
from tests.algorithms.linear_quadratic import B, F, LinearQuadratic


def test_norms_are_those_of_powers_of_the_closed_loop() -> None:
    rollouts = roll_out(LinearQuadratic(), linear, 0.1 * states(), 10)
    jacobians = closed_loop_jacobians(rollouts, np.ones(3))
    norms = product_norms(jacobians, rollouts.lengths.tolist(), (1, 3, 8, 16))
    for horizon in (1, 3, 8):
        power = np.linalg.matrix_power(F + B @ GAIN, horizon)
        assert len(norms[horizon]) == 12 * (10 - horizon + 1)
        np.testing.assert_allclose(norms[horizon], np.linalg.norm(power, 2), rtol=1e-12)
    assert norms[16].size == 0


def test_a_product_has_the_last_step_leftmost() -> None:
    first, second = np.array([[0.0, 3.0], [0.0, 0.0]]), np.array([[1.0, 0.0], [0.0, 0.0]])
    assert not (first @ second).any()
    norms = product_norms(np.stack([first, second])[:, None], [2], (2,))
    assert norms[2] == pytest.approx(3.0)


def test_units_scale_and_leave_out_what_is_not_seen() -> None:
    rollouts = roll_out(LinearQuadratic(), linear, 0.1 * states(), 1)
    scaled = closed_loop_jacobians(rollouts, np.array([2.0, 0.0, 0.5]))
    whole = F + B @ GAIN
    expected = [[whole[0, 0], whole[0, 2] * 0.25], [whole[2, 0] * 4.0, whole[2, 2]]]
    np.testing.assert_allclose(scaled[0, 0], expected)


def test_windows_stay_within_episodes_and_are_bounded() -> None:
    jacobians = np.ones((1000, 2, 1, 1))
    jacobians[5:, 0] = np.nan  # the first episode ended after five steps
    norms = product_norms(jacobians, [5, 1000], (4,))
    assert 0.8 * WINDOWS / 2 < norms[4].size <= WINDOWS
    assert np.isfinite(norms[4]).all()
