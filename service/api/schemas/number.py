"""Numbers in JSON, which has no NaN and no infinity: null stands for a number that is not finite.

And what else JSON cannot say.
"""

import math
from collections.abc import Iterator, Mapping

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


def unsayable(field: str, value: object) -> Iterator[str]:
    """Yield what JSON cannot say of a value, each with its field (`algorithms[0].config.noise`)."""
    if isinstance(value, Mapping):
        for name, each in value.items():
            yield from unsayable(f"{field}.{name}" if field else str(name), each)
    elif isinstance(value, list | tuple):
        for place, each in enumerate(value):
            yield from unsayable(f"{field}[{place}]", each)
    elif isinstance(value, float) and not math.isfinite(value):
        yield f"{field}: is {value}, where a finite number is expected"
    elif not isinstance(value, str | int | float | None):
        yield f"{field}: is a {type(value).__name__}, which cannot be sent as JSON"
