"""Measurements: adding new ones, reading one run's, reading a whole sweep's as columns."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Column, Connection, Row, ScalarSelect, Select, case, false, func, or_, select

from algorithms.measurement import Measurement
from service.model.run import Run, RunStatus
from service.model.run_curve import RETURNS, RunCurve
from service.model.run_name import RunName
from service.store.reading import diagnostics
from service.store.reading.rows import noun_of
from service.store.reading.runs import named, run_of, select_runs, spec_of
from service.store.tables import measurements, runs, sweeps
from service.store.upkeep.copy_in import copy_in

COLUMNS = tuple(column.name for column in measurements.columns)
ABSCISSAE: Mapping[str, Column[Any]] = {
    "timesteps": measurements.c.timestep,
    "updates": measurements.c.updates,
    "jacobians": measurements.c.jacobians,
    "seconds": measurements.c.seconds,
}


def add(
    connection: Connection, taken: Sequence[tuple[int, Measurement]]
) -> list[tuple[int, Measurement]]:
    """Write measurements (run number, measurement) and return those that were new.

    A run has one measurement at a timestep: the first one written stays.
    """
    if not taken:
        return []
    known = _known(connection, taken)
    fresh: dict[tuple[int, int], Measurement] = {}
    for number, measurement in taken:
        key = (number, measurement.timestep)
        if key not in known:
            fresh.setdefault(key, measurement)
    if fresh:
        _insert(connection, fresh)
    return [(number, measurement) for (number, _), measurement in fresh.items()]


def _known(
    connection: Connection, taken: Sequence[tuple[int, Measurement]]
) -> set[tuple[int, int]]:
    """The (run number, timestep) that are written already, of runs that tell something again."""
    latest = _latest(connection, {number for number, _ in taken})
    again = [(number, m.timestep) for number, m in taken if m.timestep <= latest.get(number, -1)]
    if not again:  # usually
        return set()
    query = select(measurements.c.run_number, measurements.c.timestep).where(
        measurements.c.run_number.in_({number for number, _ in again}),
        measurements.c.timestep.between(min(t for _, t in again), max(t for _, t in again)),
    )
    return {(number, timestep) for number, timestep in connection.execute(query)}


def _latest(connection: Connection, numbers: Collection[int]) -> dict[int, int]:
    """The timestep of each run's newest measurement, for those that have any."""
    newest = (
        select(func.max(measurements.c.timestep))
        .where(measurements.c.run_number == runs.c.number)
        .correlate(runs)
        .scalar_subquery()
    )
    query = select(runs.c.number, newest).where(runs.c.number.in_(numbers))
    return {number: step for number, step in connection.execute(query) if step is not None}


def _insert(connection: Connection, fresh: Mapping[tuple[int, int], Measurement]) -> None:
    """Write rows straight through the driver, which takes a third of the time."""
    set_numbers = {
        names: diagnostics.set_number(connection, names)
        for names in dict.fromkeys(tuple(each.diagnostics) for each in fresh.values())
    }
    rows = [
        (
            number,
            timestep,
            _nan_as_null(measurement.return_mean),
            _nan_as_null(measurement.return_history),
            measurement.updates,
            measurement.jacobians,
            _nan_as_null(measurement.seconds),
            set_numbers[tuple(measurement.diagnostics)],
            diagnostics.pack(measurement.diagnostics),
            _nan_as_null(measurement.compile_seconds),
        )
        for (number, timestep), measurement in fresh.items()
    ]
    if connection.dialect.name == "sqlite":
        marks = ", ".join("?" for _ in COLUMNS)
        into = f"INSERT INTO measurements ({', '.join(COLUMNS)}) VALUES ({marks})"  # noqa: S608
        connection.exec_driver_sql(into, rows)
    else:
        copy_in(connection, measurements, rows)


def _nan_as_null(value: float) -> float | None:
    return None if math.isnan(value) else value


def of_run(connection: Connection, run_id: str) -> list[Measurement]:
    """Return every measurement of a run, in order of timestep."""
    query = (
        select(measurements, runs.c.seed)
        .join(runs, runs.c.number == measurements.c.run_number)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(named(run_id))
        .order_by(measurements.c.timestep)
    )
    names = diagnostics.sets(connection)
    return [
        noun_of(
            Measurement,
            row,
            diagnostics=diagnostics.unpack(names[row.diagnostic_set], row.diagnostics),
        )
        for row in connection.execute(query)
    ]


def of_runs(
    connection: Connection, sweep_id: str, after: int, limit: int
) -> list[tuple[Run, list[Measurement]]]:
    """Return some runs of a sweep with all that they measured, from the ordinal after one on."""
    query = (
        select_runs()
        .where(sweeps.c.id == sweep_id, runs.c.ordinal > after)
        .order_by(runs.c.ordinal)
        .limit(limit)
    )
    found = {row.number: row for row in connection.execute(query)}
    names = diagnostics.sets(connection)
    points: dict[int, list[Measurement]] = {number: [] for number in found}
    measured = (
        select(measurements)
        .where(measurements.c.run_number.in_(found))
        .order_by(measurements.c.run_number, measurements.c.timestep)
    )
    for row in connection.execute(measured):
        of_set = names[row.diagnostic_set]
        values = diagnostics.unpack(of_set, row.diagnostics)
        seed = found[row.run_number].seed
        points[row.run_number].append(noun_of(Measurement, row, seed=seed, diagnostics=values))
    return [(run_of(found[number]), points[number]) for number in found]


def outlines(connection: Connection, run_ids: Sequence[str], points: int) -> dict[str, list[float]]:
    """Return about so many return_mean of each run, evenly spaced and the latest one last."""
    ids = {
        row.number: str(RunName(row.id, row.ordinal))
        for row in connection.execute(
            select(runs.c.number, runs.c.ordinal, sweeps.c.id)
            .join(sweeps, sweeps.c.number == runs.c.sweep_number)
            .where(or_(false(), *(named(run_id) for run_id in run_ids)))
        )
    }
    query = (
        select(measurements.c.run_number, measurements.c.return_mean)
        .where(measurements.c.run_number.in_(ids))
        .order_by(measurements.c.run_number, measurements.c.timestep)
    )
    values: dict[int, list[float]] = {}
    for number, value in _driver_rows(connection, query):
        values.setdefault(number, []).append(math.nan if value is None else value)
    return {
        ids[number]: column[:: -math.ceil(len(column) / points)][::-1]
        for number, column in values.items()
    }


def diagnostic_names(connection: Connection, sweep_id: str) -> list[str]:
    """Return the names of all diagnostics that runs of the sweep have measured."""
    used = (
        select(measurements.c.diagnostic_set)
        .join(runs, runs.c.number == measurements.c.run_number)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(sweeps.c.id == sweep_id)
        .distinct()
        .order_by(measurements.c.diagnostic_set)
    )
    names = diagnostics.sets(connection)
    return list(
        dict.fromkeys(name for number in connection.scalars(used) for name in names[number])
    )


def curves(
    connection: Connection,
    sweep_id: str,
    metric: str,
    x: str = "timesteps",
    ordinal: int | None = None,
) -> list[RunCurve]:
    """Return a metric of every run of the sweep in their order, or of the one of that ordinal.

    metric is "return_mean", "return_history" or a diagnostic's name, x one of ABSCISSAE. A run
    without such measurements has an empty curve. Raises ValueError for another x.
    """
    if x not in ABSCISSAE:
        raise ValueError(f"x is one of {', '.join(ABSCISSAE)}, got {x!r}")
    chosen = select(runs).join(sweeps, sweeps.c.number == runs.c.sweep_number)
    chosen = chosen.where(sweeps.c.id == sweep_id)
    if ordinal is not None:
        chosen = chosen.where(runs.c.ordinal == ordinal)
    numbers, abscissa, values = _points(connection, chosen, metric, ABSCISSAE[x])
    listed = connection.execute(chosen.order_by(runs.c.ordinal)).all()
    starts = np.searchsorted(numbers, [row.number for row in listed], side="left")
    ends = np.searchsorted(numbers, [row.number for row in listed], side="right")
    return [
        _curve(row, sweep_id, abscissa[start:end], values[start:end])
        for row, start, end in zip(listed, starts, ends, strict=True)
    ]


def _points(
    connection: Connection, chosen: Select[Any], metric: str, x: Column[Any]
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """All points of runs, in order of run and timestep: run number, x, value, each [n]."""
    query = (
        select(measurements.c.run_number, x)
        .where(
            measurements.c.run_number.in_(chosen.with_only_columns(runs.c.number))
        )  # not joined: then nothing is sorted
        .order_by(measurements.c.run_number, measurements.c.timestep)
    )
    if metric in RETURNS:
        rows = _driver_rows(connection, query.add_columns(measurements.c[metric]))
        points = np.array(rows, np.float64).reshape(-1, 3)  # NULL comes as None, read as NaN
        return points[:, 0].astype(np.int64), points[:, 1], points[:, 2]
    names = diagnostics.sets(connection)
    in_set = measurements.c.diagnostic_set
    holding = [number for number, listed in names.items() if metric in listed]
    query = query.add_columns(in_set, measurements.c.diagnostics).where(in_set.in_(holding))
    rows = _driver_rows(connection, query)
    points = np.array([row[:3] for row in rows], np.float64).reshape(-1, 3)
    values = np.empty(len(rows))
    for set_number in holding:
        places = np.flatnonzero(points[:, 2] == set_number)
        packed = [rows[place][3] for place in places]
        values[places] = diagnostics.column(names[set_number], metric, packed)
    return points[:, 0].astype(np.int64), points[:, 1], values


def _driver_rows(connection: Connection, query: Select[Any]) -> list[tuple[Any, ...]]:
    """Return the driver's own rows; SQLAlchemy's would cost three times as much."""
    return list(connection.execute(query).cursor.fetchall())


def _curve(
    row: Row[Any], sweep_id: str, x: NDArray[np.float64], values: NDArray[np.float64]
) -> RunCurve:
    name, status = str(RunName(sweep_id, row.ordinal)), RunStatus(row.status)
    return noun_of(RunCurve, row, run_id=name, spec=spec_of(row), status=status, x=x, values=values)


def final_score() -> ScalarSelect[Any]:
    """Return, as SQL, what `service.analysis.statistics.score.final_score` says of a run.

    The mean of return_mean in the last tenth of its timesteps, at least the last.

    NULL, which is NaN, where a value in that window is not a number. It goes with rows of `runs`.
    """
    of_run = measurements.c.run_number == runs.c.number
    last = select(func.max(measurements.c.timestep)).where(of_run).correlate(runs)
    at_end = or_(
        10 * measurements.c.timestep > 9 * runs.c.timesteps,
        measurements.c.timestep == last.scalar_subquery(),
    )
    value = measurements.c.return_mean
    mean = case((func.count() == func.count(value), func.avg(value)))
    return select(mean).where(of_run, at_end).correlate(runs).scalar_subquery()
