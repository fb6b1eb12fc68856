"""Additions to a sweep: seeds, entries, or more timesteps for its present runs.

An addition and the new request are one transaction. The addition refers to the request that the
caller had seen: if that has changed meanwhile, it is refused. A run that is extended is queued
again. Its worker resumes it at its last checkpoint, or starts again if that is gone: the bits are
the same, and present measurements stay.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from sqlalchemy import ColumnElement, Connection, Row, delete, func, insert, select, update

from algorithms.measurement import MEASURE_EVERY
from service.model.request.growth import with_seeds, with_timesteps
from service.model.run import RunStatus
from service.model.sweep import Sweep, SweepStatus
from service.store.claiming.moves import AGAIN, change
from service.store.reading import events, sweep_names
from service.store.reading.runs import columns_of, spec_of
from service.store.reading.sweeps import get, named
from service.store.refusal import ImpossibleMoveError
from service.store.tables import measurements, runs, sweeps
from workers.messages.run_spec import RunSpec

Json = Mapping[str, Any]
Version = Callable[[str], int]
"""Of an environment, as it is now."""


class Cell(NamedTuple):
    """A cell of a sweep: the spec of its first run, the place of its entry, its number."""

    spec: RunSpec
    entry: int
    number: int
    environment_version: int


def cells(connection: Connection, sweep_id: str) -> list[Cell]:
    """Return the cells of a sweep, in the order that they were made."""
    number = select(sweeps.c.number).where(named(sweep_id)).scalar_subquery()
    firsts = select(func.min(runs.c.number)).where(runs.c.sweep_number == number)
    query = select(runs).where(runs.c.number.in_(firsts.group_by(runs.c.cell)))
    return [
        Cell(spec_of(row), row.entry, row.cell, row.environment_version)
        for row in connection.execute(query.order_by(runs.c.cell))
    ]


def add_seeds(
    connection: Connection, sweep_id: str, seen: Json, seeds: Sequence[int], version: Version
) -> Sweep:
    """Add runs of these seeds to every cell. Raises NotFoundError, ImpossibleMoveError."""
    row = _open(connection, sweep_id, seen)
    own = cells(connection, sweep_id)
    _refuse_other_versions(own, version)
    added = [(replace(cell.spec, seed=seed), cell) for cell in own for seed in seeds]
    _insert(connection, row, added)
    return _grown(connection, row, with_seeds(seen, seeds), "added")


def add_entries(
    connection: Connection,
    sweep_id: str,
    seen: Json,
    request: Json,
    specs: Sequence[RunSpec],
    entries: Sequence[int],
    version: Version,
) -> Sweep:
    """Add the runs of new entries, each with the place of its own; `request` has them too.

    Raises NotFoundError, ImpossibleMoveError.
    """
    row = _open(connection, sweep_id, seen)
    first = select(func.max(runs.c.cell) + 1).where(runs.c.sweep_number == row.number)
    numbers: dict[RunSpec, int] = {}
    start = connection.scalar(first) or 0
    added = []
    for spec, entry in zip(specs, entries, strict=True):
        number = numbers.setdefault(spec.cell, start + len(numbers))
        added.append((spec, Cell(spec, entry, number, version(spec.environment))))
    _insert(connection, row, added)
    sweep_names.add(connection, row.number, "algorithm", [spec.algorithm for spec in specs])
    return _grown(connection, row, request, "added")


def refuse(
    connection: Connection, sweep_id: str, seen: Json, version: Version, *, is_longer: bool
) -> None:
    """Raise what growing the sweep would: NotFoundError, ImpossibleMoveError."""
    _open(connection, sweep_id, seen)
    if is_longer:
        _refuse_training(get(connection, sweep_id))
    _refuse_other_versions(cells(connection, sweep_id), version)


def extend(
    connection: Connection, sweep_id: str, seen: Json, timesteps: int, version: Version
) -> Sweep:
    """Give every run of a sweep more timesteps; those that reached their end are queued again.

    Raises NotFoundError, ImpossibleMoveError.
    """
    row = _open(connection, sweep_id, seen)
    sweep = get(connection, sweep_id)
    _refuse_training(sweep)
    own = cells(connection, sweep_id)
    _refuse_other_versions(own, version)
    if all(cell.spec.timesteps == timesteps for cell in own):
        return sweep
    lengthen(connection, row, runs.c.sweep_number == row.number, timesteps, "more timesteps")
    return _grown(connection, row, with_timesteps(seen, timesteps), "extended")


def lengthen(
    connection: Connection,
    row: Row[Any],
    condition: ColumnElement[bool],
    timesteps: int,
    reason: str,
) -> None:
    """Give runs of a sweep more timesteps; those that reached their end are queued again."""
    numbers = select(runs.c.number).where(condition)
    off_grid = measurements.c.timestep % MEASURE_EVERY != 0  # of an end that is none any more
    connection.execute(delete(measurements).where(measurements.c.run_number.in_(numbers), off_grid))
    again = {"score": None, "kept_bytes": None, **AGAIN, **_waiting(row, reason)}
    change(connection, condition & (runs.c.status == RunStatus.SUCCEEDED), again)
    connection.execute(update(runs).where(condition).values(timesteps=timesteps))


def _open(connection: Connection, sweep_id: str, seen: Json) -> Row[Any]:
    """Return the row of a sweep that can grow."""
    sweep = get(connection, sweep_id)
    if sweep.status is SweepStatus.CANCELLED:
        raise ImpossibleMoveError(f"sweep {sweep_id} was cancelled: uncancel it first")
    row = connection.execute(select(sweeps).where(named(sweep_id))).one()
    if row.question is not None:
        does = "asks a question" if row.search is None else "searches"
        raise ImpossibleMoveError(
            f"sweep {sweep_id} {does}, which says what runs it gets: submit another sweep"
        )
    if row.request != seen:
        raise ImpossibleMoveError(
            f"sweep {sweep_id} was changed meanwhile: load it again and repeat this"
        )
    return row


def _refuse_training(sweep: Sweep) -> None:
    if sweep.runs.running:
        raise ImpossibleMoveError(
            f"{sweep.runs.running} runs of sweep {sweep.id} are in training: extend it when they "
            "have ended"
        )


def _refuse_other_versions(own: Sequence[Cell], version: Version) -> None:
    for cell in own:
        task = cell.spec.environment
        if (now := version(task)) != cell.environment_version:
            raise ImpossibleMoveError(
                f"its runs are in version {cell.environment_version} of {task}, and this service "
                f"has version {now}: submit it again"
            )


def _waiting(row: Row[Any], reason: str) -> dict[str, Any]:
    """Status and reason of runs that are to start, if their sweep is not paused."""
    if row.paused_at is None:
        return {"status": RunStatus.QUEUED, "reason": reason}
    return {"status": RunStatus.PAUSED, "reason": "its sweep is paused"}


def _insert(connection: Connection, row: Row[Any], added: Sequence[tuple[RunSpec, Cell]]) -> None:
    """Write new runs, numbered on from the last one."""
    last = select(func.max(runs.c.ordinal)).where(runs.c.sweep_number == row.number)
    start = (connection.scalar(last) or 0) + 1
    connection.execute(
        insert(runs),
        [
            {
                "sweep_number": row.number,
                "ordinal": start + place,
                "cell": cell.number,
                "entry": cell.entry,
                "environment_version": cell.environment_version,
                **_waiting(row, ""),
                **columns_of(spec),
            }
            for place, (spec, cell) in enumerate(added)
        ],
    )


def _grown(connection: Connection, row: Row[Any], request: Json, how: str) -> Sweep:
    """Write the request of a sweep that has grown, with its event."""
    of_sweep = sweeps.c.number == row.number
    connection.execute(update(sweeps).where(of_sweep).values(request=request))
    events.append(connection, [events.sweep_changed(row.number, row.id, how)])
    return get(connection, row.id)
