"""Moving runs from one status to another, with their events."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import ColumnElement, Connection, select, update

from service.model.move import TRANSITIONS, Move
from service.model.run import FINAL, RunStatus
from service.model.run_name import RunName
from service.store.column_types import now
from service.store.reading import events
from service.store.tables import is_running, runs, sweeps

AGAIN: Mapping[str, Any] = {"finished_at": None, "losses": 0, "not_before": 0.0}
"""Of a run that had ended and is queued again."""


def move(
    connection: Connection,
    asked: Move,
    condition: ColumnElement[bool],
    reason: str,
    *,
    is_paused: bool,
) -> None:
    """Move those runs that meet the condition, of sweeps that are paused or are not.

    A retried run starts without lost workers; its attempts stay. Cancelling asks the workers of
    running runs to stop them.
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
    if transition.sources & FINAL:
        values |= AGAIN
    change(connection, condition & runs.c.status.in_(transition.sources), values)


def change(connection: Connection, condition: ColumnElement[bool], values: dict[str, Any]) -> None:
    """Write new values of runs, their status and reason among them, with the events."""
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
    if values["status"] not in FINAL:  # what a question was answered by may change
        is_settled = sweeps.c.number.in_(names) & (sweeps.c.question == "settled")
        connection.execute(update(sweeps).where(is_settled).values(question="open"))
