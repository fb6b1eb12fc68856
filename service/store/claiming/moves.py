"""Moving runs that no worker holds from one status to another, with their events."""

from collections.abc import Collection
from typing import Any

from sqlalchemy import ColumnElement, Connection, select, update

from service.model.run import RunStatus
from service.store.column_types import now
from service.store.reading import events
from service.store.reading.runs import run_name
from service.store.tables import runs, sweeps

WAITING = frozenset({RunStatus.QUEUED, RunStatus.PAUSED})


def move(
    connection: Connection,
    condition: ColumnElement[bool],
    sources: Collection[RunStatus],
    target: RunStatus,
    reason: str,
) -> None:
    """Move those runs that meet the condition and stand at one of the sources.

    A run that is tried again has lost no worker yet; its attempts stay.
    """
    values: dict[str, Any] = {"status": target, "reason": reason}
    if target.is_final:
        values["finished_at"] = now()
    if RunStatus.FAILED in sources:
        values |= {"finished_at": None, "losses": 0, "not_before": 0.0}
    moved = connection.execute(
        update(runs)
        .where(condition, runs.c.status.in_(sources))
        .values(values)
        .returning(runs.c.sweep_number, runs.c.ordinal, runs.c.attempt, runs.c.timestep)
    ).all()
    of_sweeps = sweeps.c.number.in_({row.sweep_number for row in moved})
    named_sweeps = connection.execute(select(sweeps.c.number, sweeps.c.id).where(of_sweeps))
    names = {row.number: row.id for row in named_sweeps}
    events.append(
        connection,
        [
            events.run_changed(
                row.sweep_number,
                run_name(names[row.sweep_number], row.ordinal),
                status=target,
                reason=reason,
                attempt=row.attempt,
                timestep=row.timestep,
            )
            for row in sorted(moved, key=lambda row: row.ordinal)
        ],
    )
