"""Curves: a metric of every run of a sweep, as arrays.

A sweep may have millions of points. They are read some runs at a time, so that few of them are
Python's objects at once, and runs that were measured at the same places share these.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Column, Connection, Row, Select, func, or_, select

from service.model.run import RunStatus
from service.model.run_curve import RETURNS, RunCurve
from service.model.run_name import RunName
from service.store.reading import diagnostics
from service.store.reading.measurements import by_points, driver_rows
from service.store.reading.rows import noun_of
from service.store.reading.runs import spec_of
from service.store.tables import measurements, runs, sweeps

POINTS_AT_ONCE = 20_000
"""So many are Python's objects at a time, of some 200 bytes each; then they are arrays."""
ABSCISSAE: Mapping[str, Column[Any]] = {
    "timesteps": measurements.c.timestep,
    "updates": measurements.c.updates,
    "jacobians": measurements.c.jacobians,
    "seconds": measurements.c.seconds,
}


def curves(
    connection: Connection,
    sweep_id: str,
    metric: str,
    x: str = "timesteps",
    ordinal: int | None = None,
    *,
    only_ends: bool = False,
) -> list[RunCurve]:
    """Return a metric of every run of the sweep in their order, or of the one of that ordinal.

    metric is "return_mean", "return_history" or a diagnostic's name, x one of ABSCISSAE. A run
    without such measurements has an empty curve. With `only_ends`, curves have no points but those
    of the last tenth of the run's timesteps, and the last. Raises ValueError for another x.
    """
    if x not in ABSCISSAE:
        raise ValueError(f"x is one of {', '.join(ABSCISSAE)}, got {x!r}")
    chosen = select(runs).join(sweeps, sweeps.c.number == runs.c.sweep_number)
    chosen = chosen.where(sweeps.c.id == sweep_id).order_by(runs.c.ordinal)
    if ordinal is not None:
        chosen = chosen.where(runs.c.ordinal == ordinal)
    column = Metric.of(connection, metric)
    found: list[RunCurve] = []
    most = 10 * POINTS_AT_ONCE if only_ends else POINTS_AT_ONCE
    for listed in by_points(connection.execute(chosen).all(), most):
        query = _points_of(listed, ABSCISSAE[x], only_ends=only_ends)
        numbers, abscissa, values = column.read(connection, query)
        starts = np.searchsorted(numbers, [row.number for row in listed], side="left")
        ends = np.searchsorted(numbers, [row.number for row in listed], side="right")
        for row, start, end in zip(listed, starts, ends, strict=True):
            grid = _shared(abscissa[start:end], found)
            found.append(_curve(row, sweep_id, grid, values[start:end]))
    return found


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


def _shared(grid: NDArray[np.float64], found: Sequence[RunCurve]) -> NDArray[np.float64]:
    """Return the grid of the run before where it is the same: along timesteps, nearly all are."""
    if found and np.array_equal(found[-1].x, grid):
        return found[-1].x
    return grid.copy()


@dataclass(frozen=True)
class Metric:
    """A metric of measurements, as it is stored.

    name  "return_mean", "return_history" or a diagnostic's
    sets  for a diagnostic: the names in each set that has it, by its number
    """

    name: str
    sets: Mapping[int, Sequence[str]]

    @classmethod
    def of(cls, connection: Connection, name: str) -> "Metric":
        """Return the metric of that name."""
        sets = {} if name in RETURNS else diagnostics.sets(connection)
        return cls(name, {number: names for number, names in sets.items() if name in names})

    def read(
        self, connection: Connection, query: Select[Any]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Read run number, x and value of the points of a query of the first two, each [n]."""
        if self.name in RETURNS:
            rows = driver_rows(connection, query.add_columns(measurements.c[self.name]))
            points = np.array(rows, np.float64).reshape(-1, 3)  # NULL comes as None, read as NaN
            return points[:, 0].astype(np.int64), points[:, 1].copy(), points[:, 2].copy()
        in_set = measurements.c.diagnostic_set
        query = query.add_columns(in_set, measurements.c.diagnostics).where(in_set.in_(self.sets))
        rows = driver_rows(connection, query)
        points = np.array([row[:3] for row in rows], np.float64).reshape(-1, 3)
        values = np.empty(len(rows))
        for set_number, names in self.sets.items():
            places = np.flatnonzero(points[:, 2] == set_number)
            packed = [rows[place][3] for place in places]
            values[places] = diagnostics.column(names, self.name, packed)
        return points[:, 0].astype(np.int64), points[:, 1].copy(), values


def _curve(
    row: Row[Any], sweep_id: str, x: NDArray[np.float64], values: NDArray[np.float64]
) -> RunCurve:
    name, status = str(RunName(sweep_id, row.ordinal)), RunStatus(row.status)
    return noun_of(RunCurve, row, run_id=name, spec=spec_of(row), status=status, x=x, values=values)
