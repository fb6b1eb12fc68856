"""Numbers in JSON, which has no NaN and no infinity: null stands where one is not finite."""

import math

from service.analysis.curves import Floats

SIGNIFICANT_DIGITS = 9

Numbers = list[float | None]


def finite_or_none(value: float) -> float | None:
    """Return a number as JSON can say it."""
    return value if math.isfinite(value) else None


def numbers(values: Floats) -> Numbers:
    """Return values [n] rounded to nine significant digits, None where one is not finite."""
    return [
        float(f"{value:.{SIGNIFICANT_DIGITS}g}") if math.isfinite(value) else None
        for value in values.tolist()
    ]
