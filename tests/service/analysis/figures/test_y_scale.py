"""The scale of a figure's y axis, and what is smoothed on it."""

import numpy as np
import pytest

from service.analysis.figures.y_scale import YScale, robust_range, y_scale


def test_a_logarithmic_axis_takes_positive_values_only() -> None:
    assert y_scale(np.array([0.02, 5.0]), is_log=True) == YScale("log", floor=0.01)
    assert y_scale(np.array([-3.0, 5.0]), is_log=True) == YScale("asinh", 0.1)
    assert y_scale(np.array([-3.0, 5.0]), is_log=False) == YScale()
    assert y_scale(np.empty(0), is_log=True) == YScale()


def test_smoothing_averages_what_the_axis_shows() -> None:
    values = np.array([3.0, np.nan, 1.0, 2.0])
    assert YScale().smooth(values, 0.0)[[0, 2, 3]] == pytest.approx([3.0, 1.0, 2.0])
    smoothed = YScale().smooth(values, 0.5)
    assert smoothed[[0, 2, 3]] == pytest.approx([3.0, 1.25 / 0.75, 1.625 / 0.875])
    assert np.isnan(smoothed[1])
    log = y_scale(np.array([1.0, 100.0]), is_log=True)
    assert log.smooth(np.array([1.0, 100.0]), 0.5) == pytest.approx([1.0, 100 ** (2 / 3)])


def test_outliers_do_not_set_a_robust_range() -> None:
    values = np.append(np.linspace(0.0, 1.0, 99), 1e9)
    low, high = robust_range(values)
    assert low == pytest.approx(0.0, abs=0.02)
    assert high == pytest.approx(1.0, abs=0.02)
