"""Moving runs from one status to another, with their events."""

from typing import Any

from sqlalchemy import ColumnElement, Connection, select, update

from service.model.move import TRANSITIONS, Move
from service.model.run import RunStatus
from service.model.run_name import RunName
from service.store.column_types import now
from service.store.reading import events
from service.store.tables import is_running, runs, sweeps


def move(
    connection: Connection,
    asked: Move,
    condition: ColumnElement[bool],
    reason: str,
    *,
    is_paused: bool,
) -> None:
    """Move those runs that meet the condition, of sweeps that are paused or are not.

    A run that is tried again has lost no worker yet; its attempts stay. Cancelling asks the
    workers of running ones to stop them.
    """
    if asked == "cancel":
        connection.execute(
            update(runs)
            .where(condition, is_running)
            .values(is_cancelling=True, reason="cancelling: its worker has been told to stop")
        )
    transition = TRANSITIONS[asked]
    is_held_back = is_paused and transition.target is RunStatus.QUEUED
    target = RunStatus.PAUSED if is_held_back else transition.target
    values: dict[str, Any] = {"status": target, "reason": reason}
    if target.is_final:
        values["finished_at"] = now()
    if RunStatus.FAILED in transition.sources:
        values |= {"finished_at": None, "losses": 0, "not_before": 0.0}
    moved = _update(connection, condition & runs.c.status.in_(transition.sources), values)
    if RunStatus.FAILED in transition.sources:  # what a question was answered by may change
        reopened = sweeps.c.number.in_(moved) & sweeps.c.question.is_not(None)
        connection.execute(update(sweeps).where(reopened).values(question="open"))


def _update(
    connection: Connection, condition: ColumnElement[bool], values: dict[str, Any]
) -> set[int]:
    """Write the new values, with the events; return the numbers of the sweeps."""
    moved = connection.execute(
        update(runs)
        .where(condition)
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
                RunName(names[row.sweep_number], row.ordinal),
                status=values["status"],
                reason=values["reason"],
                attempt=row.attempt,
                timestep=row.timestep,
            )
            for row in sorted(moved, key=lambda row: row.ordinal)
        ],
    )
    return set(names)
