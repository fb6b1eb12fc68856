"""Measurements: adding new ones, reading those of runs."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, Row, ScalarSelect, Select, case, false, func, or_, select

from algorithms.measurement import MEASURE_EVERY, Measurement
from service.model.run import Run
from service.model.run_name import RunName
from service.store.at_once import among
from service.store.reading import packed
from service.store.reading.rows import noun_of
from service.store.reading.runs import named, run_of, select_runs
from service.store.tables import measurements, runs, sweeps
from service.store.upkeep.copy_in import copy_in

POINTS_AT_ONCE = 1_000
"""Measurements, with all diagnostics, to read together; each takes about a kilobyte."""
MOST_RUNS = 1000
"""Runs to read by their numbers in one query."""
COLUMNS = tuple(column.name for column in measurements.columns)


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
    """The (run number, timestep) that are written already, of runs that report them again."""
    latest = _latest(connection, {number for number, _ in taken})
    again = [(number, m.timestep) for number, m in taken if m.timestep <= latest.get(number, -1)]
    if not again:  # usually
        return set()
    query = select(measurements.c.run_number, measurements.c.timestep).where(
        among(measurements.c.run_number, {number for number, _ in again}),
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
    query = select(runs.c.number, newest).where(among(runs.c.number, numbers))
    return {number: step for number, step in connection.execute(query) if step is not None}


def _insert(connection: Connection, fresh: Mapping[tuple[int, int], Measurement]) -> None:
    """Write rows straight through the driver, which takes a third of the time."""
    names = [tuple(measurement.diagnostics) for measurement in fresh.values()]
    set_numbers = {each: packed.set_number(connection, each) for each in dict.fromkeys(names)}
    rows = [
        (
            number,
            timestep,
            None if math.isnan(measurement.return_mean) else measurement.return_mean,
            measurement.updates,
            measurement.jacobians,
            set_numbers[of_set],
            packed.pack(measurement),
        )
        for ((number, timestep), measurement), of_set in zip(fresh.items(), names, strict=True)
    ]
    if connection.dialect.name == "sqlite":
        marks = ", ".join("?" for _ in COLUMNS)
        into = f"INSERT INTO measurements ({', '.join(COLUMNS)}) VALUES ({marks})"  # noqa: S608
        connection.exec_driver_sql(into, rows)
    else:
        copy_in(connection, measurements, rows)


def of_run(connection: Connection, run_id: str) -> list[Measurement]:
    """Return every measurement of a run, in order of timestep."""
    query = (
        select(measurements, runs.c.seed)
        .join(runs, runs.c.number == measurements.c.run_number)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(named(run_id))
        .order_by(measurements.c.timestep)
    )
    names = packed.sets(connection)
    return [_measurement(row, row.seed, names) for row in connection.execute(query)]


def _measurement(row: Row[Any], seed: int, names: Mapping[int, Sequence[str]]) -> Measurement:
    values = packed.unpack(names[row.diagnostic_set], row.packed)
    return noun_of(Measurement, row, seed=seed, **values)


def of_runs(
    connection: Connection, sweep_id: str, after: int, limit: int
) -> list[tuple[Run, list[Measurement]]]:
    """Return some runs of a sweep with their measurements, from the ordinal after one on.

    They are at most `limit`, and fewer where their points would be many more than POINTS_AT_ONCE.
    """
    query = (
        select_runs()
        .where(sweeps.c.id == sweep_id, runs.c.ordinal > after)
        .order_by(runs.c.ordinal)
        .limit(limit)
    )
    listed = next(by_points(connection.execute(query).all(), POINTS_AT_ONCE), [])
    found = {row.number: row for row in listed}
    names = packed.sets(connection)
    points: dict[int, list[Measurement]] = {number: [] for number in found}
    measured = (
        select(measurements)
        .where(among(measurements.c.run_number, found))
        .order_by(measurements.c.run_number, measurements.c.timestep)
    )
    for row in connection.execute(measured):
        seed = found[row.run_number].seed
        points[row.run_number].append(_measurement(row, seed, names))
    return [(run_of(found[number]), points[number]) for number in found]


def outlines(connection: Connection, run_ids: Sequence[str], points: int) -> dict[str, list[float]]:
    """Return about this many return_mean of each run, evenly spaced, the latest one last."""
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
        .where(among(measurements.c.run_number, ids))
        .order_by(measurements.c.run_number, measurements.c.timestep)
    )
    values: dict[int, list[float]] = {}
    for number, value in driver_rows(connection, query):
        values.setdefault(number, []).append(math.nan if value is None else value)
    return {
        ids[number]: column[:: -math.ceil(len(column) / points)][::-1]
        for number, column in values.items()
    }


def diagnostic_names(connection: Connection, sweep_id: str) -> list[str]:
    """Return the names of all diagnostics that runs of the sweep have measured."""
    own = select(runs.c.number).join(sweeps, sweeps.c.number == runs.c.sweep_number)
    used = (
        select(measurements.c.diagnostic_set)
        .where(measurements.c.run_number.in_(own.where(sweeps.c.id == sweep_id)))  # not joined:
        .distinct()  # SQLite would sort all measurements, in memory
    )
    names = packed.sets(connection)
    numbers = sorted(connection.scalars(used))
    return list(dict.fromkeys(name for number in numbers for name in names[number]))


def by_points(listed: Sequence[Row[Any]], most: int) -> Iterator[list[Row[Any]]]:
    """Yield rows of runs, so many together that they have about as many points as that."""
    together: list[Row[Any]] = []
    points = 0
    for row in listed:
        together.append(row)
        points += max(row.timestep // MEASURE_EVERY, most // MOST_RUNS)
        if points >= most:
            yield together
            together, points = [], 0
    if together:
        yield together


def driver_rows(connection: Connection, query: Select[Any]) -> list[tuple[Any, ...]]:
    """Return the driver's own rows; SQLAlchemy's would cost three times as much."""
    return list(connection.execute(query).cursor.fetchall())


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
