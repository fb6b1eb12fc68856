"""Medians: the findings of several runs as those of one.

A number that does not exist in a run, a NaN, is left out.
"""

from collections.abc import Iterable

import numpy as np

from algorithms.diagnostics.finding import Finding

Name = tuple[str, str, int | None, float | None]
"""A finding without its value: diagnostic, quantity, horizon, noise."""
Medians = dict[Name, float]


def medians(runs: Iterable[Iterable[Finding]]) -> Medians:
    """The median over the runs of each number, NaN where no run has it."""
    values: dict[Name, list[float]] = {}
    for findings in runs:
        for *name, value in findings:
            values.setdefault(tuple(name), []).append(value)  # type: ignore[arg-type]
    return {name: median(each) for name, each in values.items()}


def median(values: list[float]) -> float:
    """The median of the numbers that are not NaN; NaN if there are none."""
    numbers = [value for value in values if not np.isnan(value)]
    return float(np.median(numbers)) if numbers else float("nan")
