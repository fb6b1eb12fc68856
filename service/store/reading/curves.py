"""Curves: a metric of every run of a sweep, as arrays.

A sweep may have millions of points. They are read some runs at a time, so that few of them are
Python's objects at once.
"""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import (
    Column,
    ColumnElement,
    Connection,
    Row,
    Select,
    case,
    func,
    null,
    or_,
    select,
)

from service.model.run import FINAL, RunStatus
from service.model.run_curve import RETURNS, RunCurve
from service.model.run_name import RunName
from service.store.curve_memory import CurveMemory, Line
from service.store.reading import diagnostics
from service.store.reading.measurements import by_points
from service.store.reading.rows import noun_of
from service.store.reading.runs import spec_of
from service.store.tables import measurements, runs, sweeps

POINTS_AT_ONCE = 20_000
"""So many values are Python's objects at a time, of some 100 bytes each; then they are arrays."""
ABSCISSAE: Mapping[str, Column[Any]] = {
    "timesteps": measurements.c.timestep,
    "updates": measurements.c.updates,
    "jacobians": measurements.c.jacobians,
    "seconds": measurements.c.seconds,
}


def curves(
    connection: Connection,
    memory: CurveMemory,
    sweep_id: str,
    metrics: Sequence[str],
    x: str = "timesteps",
    ordinal: int | None = None,
    *,
    only_ends: bool = False,
) -> list[list[RunCurve]]:
    """Return each metric of every run of the sweep in their order, or of the one of that ordinal.

    A metric is "return_mean", "return_history" or a diagnostic's name, x one of ABSCISSAE. A run
    without such measurements has an empty curve. With `only_ends`, curves have no points but those
    of the last tenth of the run's timesteps, and the last. What the memory has of runs that have
    ended is not read again. Raises ValueError for another x.
    """
    if x not in ABSCISSAE:
        raise ValueError(f"x is one of {', '.join(ABSCISSAE)}, got {x!r}")
    chosen = select(runs).join(sweeps, sweeps.c.number == runs.c.sweep_number)
    chosen = chosen.where(sweeps.c.id == sweep_id).order_by(runs.c.ordinal)
    if ordinal is not None:
        chosen = chosen.where(runs.c.ordinal == ordinal)
    rows = connection.execute(chosen).all()
    seen = (x, only_ends)
    lines = [_remembered(memory, rows, (metric, *seen)) for metric in metrics]
    unread = [row for row in rows if any(row.number not in known for known in lines)]
    asked = Metrics.of(connection, metrics)
    most = (10 if only_ends else 1) * POINTS_AT_ONCE // len(metrics)
    for listed in by_points(unread, most):
        query = _points_of(listed, ABSCISSAE[x], only_ends=only_ends)
        found = asked.read(connection, query)
        for metric, known, points in zip(metrics, lines, found, strict=True):
            known.update(points.of_each([row.number for row in listed]))
            for row in listed:
                if row.status in FINAL:
                    memory.keep(_key(row, (metric, *seen)), known[row.number])
    return [[_curve(row, sweep_id, known[row.number]) for row in rows] for known in lines]


def _remembered(
    memory: CurveMemory, rows: Sequence[Row[Any]], seen: tuple[Hashable, ...]
) -> dict[int, Line]:
    """What the memory has of runs, by their numbers."""
    kept = ((row.number, memory.get(_key(row, seen))) for row in rows if row.status in FINAL)
    return {number: line for number, line in kept if line is not None}


def _key(row: Row[Any], seen: tuple[Hashable, ...]) -> Hashable:
    return (row.number, row.attempt, row.finished_at, *seen)


def _points_of(listed: Sequence[Row[Any]], x: Column[Any], *, only_ends: bool) -> Select[Any]:
    """Run number and x of all points of runs, or of those at their ends; in order of both."""
    of_run, timestep = measurements.c.run_number, measurements.c.timestep
    query = select(of_run, x).order_by(of_run, timestep)
    numbers = [row.number for row in listed]
    if not only_ends:
        return query.where(of_run.in_(numbers))
    same = measurements.alias("same")
    last = select(func.max(same.c.timestep)).where(same.c.run_number == runs.c.number)
    query = query.join(runs, runs.c.number == of_run).where(runs.c.number.in_(numbers))
    return query.where(
        or_(
            10 * timestep > 9 * runs.c.timesteps,
            timestep == last.correlate(runs).scalar_subquery(),
        )
    )


@dataclass(frozen=True)
class Points:
    """A metric of some runs, in order of run number and timestep, each [n]."""

    numbers: NDArray[np.int64]
    x: NDArray[np.float64]
    values: NDArray[np.float64]

    def of_each(self, numbers: Sequence[int]) -> dict[int, Line]:
        """Return the line of each run; those that were measured at the same places share these."""
        starts = np.searchsorted(self.numbers, numbers, side="left")
        ends = np.searchsorted(self.numbers, numbers, side="right")
        grid = np.empty(0)
        lines: dict[int, Line] = {}
        for number, start, end in zip(numbers, starts, ends, strict=True):
            own = self.x[start:end]
            is_same = np.array_equal(grid, own)
            grid = grid if is_same else _kept(own)
            lines[number] = Line(grid, _kept(self.values[start:end]), is_same)
        return lines


@dataclass(frozen=True)
class Metrics:
    """Metrics of measurements, as they are stored.

    names   "return_mean", "return_history" or a diagnostic's
    places  of a diagnostic in each set that has it, by the set's number; a return has none
    """

    names: Sequence[str]
    places: Mapping[str, Mapping[int, int]]

    @classmethod
    def of(cls, connection: Connection, names: Sequence[str]) -> "Metrics":
        """Return the metrics of these names."""
        own = [name for name in names if name not in RETURNS]
        sets = diagnostics.sets(connection) if own else {}
        return cls(
            names,
            {
                name: {number: of.index(name) for number, of in sets.items() if name in of}
                for name in own
            },
        )

    def read(self, connection: Connection, query: Select[Any]) -> list[Points]:
        """Read the points of a query of run number and x, of each metric those that have it."""
        query = query.add_columns(*map(self._column, self.names))
        if len(self.places) == len(self.names):
            holding = {number for places in self.places.values() for number in places}
            query = query.where(measurements.c.diagnostic_set.in_(holding))
        # One list of all values takes half the time of an array of the driver's tuples.
        cursor: Any = connection.execute(query).cursor
        flat = list(chain.from_iterable(cursor))
        width = 2 + len(self.names)
        numbers, x = np.array(flat[::width], np.int64), np.array(flat[1::width], np.float64)
        return [
            self._points(name, numbers, x, flat[place::width])
            for place, name in enumerate(self.names, start=2)
        ]

    def _column(self, name: str) -> ColumnElement[Any]:
        """A return, or the bytes of a diagnostic; NULL where a measurement does not have it."""
        if name in RETURNS:
            return measurements.c[name]
        values = {number: diagnostics.value_at(at) for number, at in self.places[name].items()}
        return case(values, value=measurements.c.diagnostic_set) if values else null()

    @staticmethod
    def _points(
        name: str, numbers: NDArray[np.int64], x: NDArray[np.float64], column: list[Any]
    ) -> Points:
        if name in RETURNS:
            return Points(numbers, x, np.array(column, np.float64))  # NULL is None is NaN
        if None in column:
            there = np.array([value is not None for value in column])
            numbers, x = numbers[there], x[there]
            column = [value for value in column if value is not None]
        return Points(numbers, x, np.frombuffer(b"".join(column), diagnostics.FLOAT64))


def _kept(part: NDArray[np.float64]) -> NDArray[np.float64]:
    """Copy a part of an array, which need not live on, for others to read."""
    own = part.copy()
    own.setflags(write=False)
    return own


def _curve(row: Row[Any], sweep_id: str, line: Line) -> RunCurve:
    return noun_of(
        RunCurve,
        row,
        run_id=str(RunName(sweep_id, row.ordinal)),
        spec=spec_of(row),
        status=RunStatus(row.status),
        x=line.x,
        values=line.values,
    )
