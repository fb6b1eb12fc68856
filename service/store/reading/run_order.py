"""The orders in which the runs of a sweep can be listed; the keys of a keyset page.

A key is (is missing, value, ordinal): runs without a value come last whichever way the order goes,
and runs of one value stay in the order they were made. A page goes on after the key that its last
run has now, which may have moved since, as runs do.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from sqlalchemy import (
    ColumnElement,
    Double,
    case,
    func,
    literal,
    null,
    select,
    tuple_,
    type_coerce,
)

from service.store.tables import attempts, measurements, runs

By = Literal["made", "entry", "seed", "w1", "w2", "timestep", "seconds", "return_mean", "score"]
Scales = Mapping[str, tuple[float, float]]
"""By environment: where the normalised scale of returns starts, and how long its unit is."""


@dataclass(frozen=True)
class RunOrder:
    """The value that runs are sorted by, and whether the largest comes first.

    scales  of the final scores, in the environments where they are known: the others come last
    """

    by: By = "made"
    is_descending: bool = False
    scales: Scales = field(default_factory=dict)

    def keys(self) -> tuple[ColumnElement[Any], ...]:
        """Return the values to compare, smallest first."""
        if self.by == "made":
            return (-runs.c.ordinal if self.is_descending else runs.c.ordinal,)
        value = self._value()
        signed = -value if self.is_descending else value
        return case((value.is_(None), 1), else_=0), func.coalesce(signed, 0.0), runs.c.ordinal

    def _value(self) -> ColumnElement[Any]:
        if self.by in COLUMNS:
            return COLUMNS[self.by] + 0.0
        if self.by == "seconds":
            return worked_seconds
        return latest_return if self.by == "return_mean" else _normalised(self.scales)

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


latest_return: ColumnElement[float | None] = type_coerce(
    select(measurements.c.return_mean)
    .where(measurements.c.run_number == runs.c.number)
    .order_by(measurements.c.timestep.desc())
    .limit(1)
    .correlate(runs)
    .scalar_subquery(),
    Double,
)

COLUMNS: Mapping[By, ColumnElement[Any]] = {
    "entry": runs.c.entry,
    "seed": runs.c.seed,
    "w1": runs.c.w1,
    "w2": runs.c.w2,
    "timestep": runs.c.timestep,
}


def _normalised(scales: Scales) -> ColumnElement[Any]:
    """The final score of a run on its environment's scale; NULL without one."""
    score = type_coerce(runs.c.score, Double)
    cases = [
        (runs.c.environment == environment, (score - start) / unit)
        for environment, (start, unit) in scales.items()
    ]
    return case(*cases, else_=null()) if cases else type_coerce(null(), Double)
