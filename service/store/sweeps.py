"""Sweeps: creating one with all its runs, reading them with counts, cancelling."""

import secrets
from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Row,
    Select,
    case,
    func,
    insert,
    select,
    update,
)

from service.run import ACTIVE, RunStatus
from service.store import events
from service.store.column_types import now
from service.store.refusal import ImpossibleMoveError, NotFoundError
from service.store.runs import end_queued
from service.store.tables import is_running, runs, sweeps
from service.sweep import RunCounts, Sweep, SweepStatus
from workers.run_spec import RunSpec


def create(
    connection: Connection,
    *,
    name: str,
    priority: int,
    request: Mapping[str, Any],
    specs: Sequence[RunSpec],
    environment_versions: Mapping[str, int],
) -> Sweep:
    """Write a sweep and its runs, which are numbered in the order of the specs."""
    sweep_id = secrets.token_hex(6)
    heading = {"id": sweep_id, "name": name, "priority": priority, "request": request}
    number = connection.execute(
        insert(sweeps).values(heading).returning(sweeps.c.number)
    ).scalar_one()
    cells = {cell: index for index, cell in enumerate(dict.fromkeys(s.cell for s in specs))}
    rows = [
        {
            "sweep_number": number,
            "ordinal": ordinal,
            "cell": cells[spec.cell],
            "algorithm": spec.algorithm,
            "environment": spec.environment,
            "environment_version": environment_versions[spec.environment],
            "seed": spec.seed,
            "w1": spec.weights[0],
            "w2": spec.weights[1],
            "config": spec.config,
            "timesteps": spec.timesteps,
        }
        for ordinal, spec in enumerate(specs)
    ]
    if rows:
        connection.execute(insert(runs), rows)
    events.append(connection, [events.sweep_changed(number, sweep_id, "created")])
    return get(connection, sweep_id)


def find(connection: Connection, sweep_id: str) -> Sweep | None:
    """Return one sweep, or None."""
    row = connection.execute(_summaries(sweeps.c.id == sweep_id)).one_or_none()
    return None if row is None else _sweep(row)


def get(connection: Connection, sweep_id: str) -> Sweep:
    """Return one sweep. Raises NotFoundError."""
    sweep = find(connection, sweep_id)
    if sweep is None:
        raise NotFoundError(f"there is no sweep {sweep_id!r}")
    return sweep


def page(connection: Connection, after: str | None, limit: int) -> list[Sweep]:
    """Return sweeps, newest first, from the one that follows the sweep named `after`."""
    numbers = select(sweeps.c.number).order_by(sweeps.c.number.desc()).limit(limit)
    if after is not None:
        last = select(sweeps.c.number).where(sweeps.c.id == after).scalar_subquery()
        numbers = numbers.where(sweeps.c.number < last)
    query = _summaries(sweeps.c.number.in_(numbers)).order_by(sweeps.c.number.desc())
    return [_sweep(row) for row in connection.execute(query)]


def cancel(connection: Connection, sweep_id: str) -> Sweep:
    """Cancel every run that has not ended: queued ones at once, running ones by their workers.

    Again is no error. Raises NotFoundError, or ImpossibleMoveError when all runs have ended.
    """
    sweep = get(connection, sweep_id)
    if sweep.status is SweepStatus.CANCELLED:
        return sweep
    if sweep.status is SweepStatus.FINISHED:
        raise ImpossibleMoveError(
            f"sweep {sweep_id} has finished: none of its runs is left to cancel"
        )
    number = connection.execute(
        update(sweeps)
        .where(sweeps.c.id == sweep_id)
        .values(cancelled_at=func.coalesce(sweeps.c.cancelled_at, now()))
        .returning(sweeps.c.number)
    ).scalar_one()
    connection.execute(
        update(runs)
        .where(runs.c.sweep_number == number, is_running)
        .values(is_cancelling=True, reason="cancelling: its worker has been told to stop")
    )
    events.append(connection, [events.sweep_changed(number, sweep_id, "cancelled")])
    end_queued(connection, runs.c.sweep_number == number, "its sweep was cancelled")
    return get(connection, sweep_id)


def _summaries(condition: ColumnElement[bool]) -> Select[Any]:
    """Sweeps with what their runs add up to."""
    counts = [
        func.count().filter(runs.c.status == status).label(status.value) for status in RunStatus
    ]
    done = case((runs.c.status.in_(ACTIVE), runs.c.timestep), else_=runs.c.timesteps)
    return (
        select(
            sweeps,
            *counts,
            func.min(runs.c.started_at).label("started_at"),
            func.coalesce(func.sum(done), 0).label("done"),
            func.coalesce(func.sum(runs.c.timesteps), 0).label("asked"),
            now().label("clock"),
        )
        .join(runs, runs.c.sweep_number == sweeps.c.number)
        .where(condition)
        .group_by(sweeps.c.number)
    )


def _sweep(row: Row[Any]) -> Sweep:
    counts = RunCounts(**{status.value: getattr(row, status.value) for status in RunStatus})
    progress = float(row.done) / float(row.asked)
    eta = None
    if counts.active == 0:
        eta = 0.0
    elif row.started_at is not None and progress > 0:
        eta = (row.clock - row.started_at) * (1 - progress) / progress
    return Sweep(
        id=row.id,
        name=row.name,
        priority=row.priority,
        request=row.request,
        created_at=row.created_at,
        started_at=row.started_at,
        status=_status(counts, row.started_at, row.cancelled_at),
        runs=counts,
        progress=progress,
        eta_seconds=eta,
    )


def _status(counts: RunCounts, started_at: float | None, cancelled_at: float | None) -> SweepStatus:
    if counts.active == 0:
        was_cut = cancelled_at is not None and counts.cancelled > 0
        return SweepStatus.CANCELLED if was_cut else SweepStatus.FINISHED
    return SweepStatus.QUEUED if started_at is None else SweepStatus.RUNNING
