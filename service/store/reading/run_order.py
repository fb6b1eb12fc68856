"""The orders in which the runs of a sweep can be listed; the keys of a keyset page.

A key is (is missing, value, ordinal): runs without a value come last whichever way the order goes,
and runs of one value stay in the order they were made. A page goes on after the key that its last
run has now, which may have moved since, as runs do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import (
    ColumnElement,
    Double,
    case,
    func,
    literal,
    select,
    tuple_,
    type_coerce,
)

from service.store.tables import attempts, measurements, runs

By = Literal["made", "timestep", "seconds", "return_mean"]


@dataclass(frozen=True)
class RunOrder:
    """By what runs are listed, and whether the largest comes first."""

    by: By = "made"
    is_descending: bool = False

    def keys(self) -> tuple[ColumnElement[Any], ...]:
        """Return what is compared, smallest first."""
        if self.by == "made":
            return (-runs.c.ordinal if self.is_descending else runs.c.ordinal,)
        value = _value(self.by)
        signed = -value if self.is_descending else value
        return case((value.is_(None), 1), else_=0), func.coalesce(signed, 0.0), runs.c.ordinal

    def after(self, last: Sequence[Any]) -> ColumnElement[bool]:
        """Return the condition of following the run that has these keys."""
        return tuple_(*self.keys()) > tuple_(*(literal(value) for value in last))


AS_MADE = RunOrder()

worked_seconds: ColumnElement[float | None] = type_coerce(
    select(func.sum(attempts.c.ended_at - attempts.c.started_at))
    .where(attempts.c.run_number == runs.c.number)
    .correlate(runs)
    .scalar_subquery(),
    Double,
)
"""How long workers have worked on a run, in its attempts that have ended; NULL without any."""


def _value(by: By) -> ColumnElement[Any]:
    if by == "timestep":
        return runs.c.timestep + 0.0
    if by == "seconds":
        return worked_seconds
    latest = (
        select(measurements.c.return_mean)
        .where(measurements.c.run_number == runs.c.number)
        .order_by(measurements.c.timestep.desc())
        .limit(1)
        .scalar_subquery()
    )
    return type_coerce(latest, Double)
