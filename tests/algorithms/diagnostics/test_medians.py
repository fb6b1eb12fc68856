"""Medians over runs, of the numbers that there are."""

import math

from algorithms.diagnostics.finding import Finding
from algorithms.diagnostics.medians import medians


def growth(horizon: int, value: float) -> Finding:
    return Finding("growth", "median_norm", horizon, None, value)


def test_each_number_has_the_median_of_the_runs_that_have_it() -> None:
    runs = [
        [growth(1, 1.0), growth(2, 5.0)],
        [growth(1, 9.0), growth(2, math.nan)],
        [growth(1, 3.0)],
    ]
    found = medians(runs)
    assert found == {growth(1, 0.0)[:-1]: 3.0, growth(2, 0.0)[:-1]: 5.0}


def test_a_number_that_no_run_has_is_nan() -> None:
    [value] = medians([[growth(1, math.nan)], [growth(1, math.nan)]]).values()
    assert math.isnan(value)
