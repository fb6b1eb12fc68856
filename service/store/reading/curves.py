"""Curves: a metric of every run of a sweep, as arrays.

A sweep may have millions of points. The database joins those of a run to one value; a point is
no object of Python.
"""

from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, Row, Select, case, func, literal, select

from service.model.processor import processor_of
from service.model.run import FINAL, RunStatus
from service.model.run_curve import RunCurve
from service.model.run_name import RunName
from service.store.curve_memory import CurveMemory, Line
from service.store.reading import packed
from service.store.reading.measurements import by_points
from service.store.reading.runs import spec_of
from service.store.tables import measurements, runs, sweeps

POINTS_AT_ONCE = 200_000
"""About so many points are asked for together."""
COUNTS: Mapping[str, str] = {
    "timesteps": "timestep",
    "updates": "updates",
    "jacobians": "jacobians",
}
"""The columns of abscissae that are integers."""
ABSCISSAE = (*COUNTS, "seconds")
Floats = NDArray[np.float64]
NO_POINTS = Line(np.empty(0), np.empty(0))


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
    without such measurements has an empty curve. With `only_ends`, curves have only the points of
    the last tenth of the run's timesteps, and the last point. Curves of ended runs that are in the
    memory are not read again. Raises ValueError for another x.
    """
    if x not in ABSCISSAE:
        raise ValueError(f"x is one of {', '.join(ABSCISSAE)}, got {x!r}")
    chosen = select(runs).join(sweeps, sweeps.c.number == runs.c.sweep_number)
    chosen = chosen.where(sweeps.c.id == sweep_id).order_by(runs.c.ordinal)
    if ordinal is not None:
        chosen = chosen.where(runs.c.ordinal == ordinal)
    rows = connection.execute(chosen).all()
    seen = (x, only_ends)
    known = {metric: _remembered(memory, rows, (metric, *seen)) for metric in metrics}
    unread = [row for row in rows if any(row.number not in lines for lines in known.values())]
    reading = Reading(packed.Layout(packed.sets(connection)), x)
    for listed in by_points(unread, POINTS_AT_ONCE):
        query = reading.query(_points_of(listed, only_ends=only_ends))
        for number, *found in connection.execute(query):
            for metric, lines in known.items():
                lines[number] = reading.line(metric, *found)
        for metric, lines in known.items():
            for row in listed:
                line = lines.setdefault(row.number, NO_POINTS)
                if row.status in FINAL:
                    memory.keep(_key(row, (metric, *seen)), line)
    runs_of = [_run(row, sweep_id) for row in rows]
    lines_of = ([known[metric][row.number] for row in rows] for metric in metrics)
    return [
        [run(line.x, line.values) for run, line in zip(runs_of, lines, strict=True)]
        for lines in lines_of
    ]


def _remembered(
    memory: CurveMemory, rows: Sequence[Row[Any]], seen: tuple[Hashable, ...]
) -> dict[int, Line]:
    """Lines of runs that are in the memory, by their numbers."""
    kept = ((row.number, memory.get(_key(row, seen))) for row in rows if row.status in FINAL)
    return {number: line for number, line in kept if line is not None}


def _key(row: Row[Any], seen: tuple[Hashable, ...]) -> Hashable:
    return (row.number, row.attempt, row.finished_at, *seen)


def _points_of(listed: Sequence[Row[Any]], *, only_ends: bool) -> Select[Any]:
    """All points of runs, or those at their ends; in order of run and timestep."""
    of_run, timestep = measurements.c.run_number, measurements.c.timestep
    query = select(measurements).order_by(of_run, timestep)
    numbers = [row.number for row in listed]
    if not only_ends:
        return query.where(of_run.in_(numbers))
    first = runs.c.timesteps * 9 // 10 + 1  # of the last tenth; a run may have measured none of it
    same = measurements.alias("same")
    last = select(func.max(same.c.timestep)).where(same.c.run_number == runs.c.number)
    latest = last.correlate(runs).scalar_subquery()
    since = case((latest < first, latest), else_=first)
    query = query.join(runs, runs.c.number == of_run).where(timestep >= since)
    return query.where(runs.c.number.in_(numbers))


class Reading:
    """Lines of runs over an abscissa; runs measured at the same places share the array of x."""

    def __init__(self, layout: packed.Layout, x: str) -> None:
        """Of one of ABSCISSAE."""
        self._layout = layout
        self._count = COUNTS.get(x)
        self._x = x
        self._shared: dict[tuple[str, str, str], Floats] = {}

    def query(self, points: Select[Any]) -> Select[Any]:
        """The number of each run, and what `line` makes lines of.

        Both databases join rows in the order of a sorted subquery (PostgreSQL's manual, "Aggregate
        Functions"; SQLite's source, SF_OrderByReqd). An ORDER BY in string_agg would sort each run
        once more.
        """
        rows = points.subquery("points")
        counts = packed.listed(rows.c[self._count]) if self._count else literal("")
        sets, floats = packed.listed(rows.c.diagnostic_set), packed.joined(rows.c.packed)
        return select(rows.c.run_number, sets, counts, floats).group_by(rows.c.run_number)

    def line(self, metric: str, sets: str, counts: str, floats: bytes) -> Line:
        """The line of a metric."""
        values, where = packed.floats(floats), self._layout.where(metric, sets)
        key = metric, sets, counts
        is_shared = key in self._shared
        if is_shared:
            x = self._shared[key]
        elif self._count:
            x = _kept(packed.integers(counts)[where.rows].astype(np.float64))
            self._shared[key] = x
        else:
            x = _kept(values[self._layout.where(self._x, sets).at[where.rows]])
        return Line(x, _kept(values[where.at]), is_shared)


def _kept(own: Floats) -> Floats:
    """Make an array read-only; no other code holds it."""
    own.setflags(write=False)
    return own


def _run(row: Row[Any], sweep_id: str) -> Callable[[Floats, Floats], RunCurve]:
    """Return the function that makes curves of a run from x and values."""
    return partial(
        RunCurve,
        str(RunName(sweep_id, row.ordinal)),
        spec_of(row),
        row.environment_version,
        RunStatus(row.status),
        processor=processor_of(row.fingerprint),
        entry=row.entry,
    )
