"""The three scores of a run, by hand."""

import math

import numpy as np
import pytest

from service.analysis.statistics.score import SCORES, area, final_score

TENTHS = np.arange(1.0, 11.0) * 800


def test_the_final_score_is_the_mean_over_the_last_tenth() -> None:
    steps = np.arange(1.0, 51.0) * 800  # of 40,000 timesteps, the last tenth holds five
    returns = np.arange(1.0, 51.0)
    assert final_score(steps, returns, 40_000) == np.mean([46, 47, 48, 49, 50])


def test_the_window_is_open_at_its_start() -> None:
    """Of 8,000 timesteps the measurement at 7,200 is not in the last tenth."""
    assert final_score(TENTHS, np.arange(10.0), 8_000) == 9.0


def test_a_short_run_is_not_averaged_over_its_start() -> None:
    """The curve rises from 0 to 0.9; return_history is the mean of all of it."""
    returns = np.linspace(0.0, 0.9, 10)
    history = np.cumsum(returns) / np.arange(1, 11)
    assert SCORES["final"].of(TENTHS, returns, 8_000) == pytest.approx(0.9)
    assert SCORES["return_history"].of(TENTHS, history, 8_000) == pytest.approx(0.45)


@pytest.mark.parametrize("steps", [[800.0], [800.0, 1600.0]])
def test_what_ends_before_its_timesteps_has_its_last_measurement(steps: list[float]) -> None:
    returns = np.arange(len(steps), dtype=np.float64)
    assert final_score(np.array(steps), returns, 1_488_000) == returns[-1]


def test_a_last_measurement_off_the_grid_counts() -> None:
    steps, returns = np.array([800.0, 1500.0]), np.array([1.0, 3.0])
    assert final_score(steps, returns, 1500) == 3.0


def test_what_is_not_finite_in_the_window_is_no_score() -> None:
    assert math.isinf(final_score(TENTHS, np.array([1.0] * 9 + [math.inf]), 8_000))
    assert math.isnan(final_score(TENTHS, np.array([1.0] * 9 + [math.nan]), 8_000))
    assert final_score(TENTHS, np.array([math.nan] + [1.0] * 9), 8_000) == 1.0


def test_area_is_the_mean_along_the_run() -> None:
    assert area(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 2.0])) == pytest.approx(5 / 3)
    assert area(np.array([800.0]), np.array([-3.0])) == -3.0


def test_every_score_is_said_in_words() -> None:
    assert "last tenth" in SCORES["final"].text
    assert "latest 100" in SCORES["return_history"].text
    assert "trapezoids" in SCORES["area"].text
