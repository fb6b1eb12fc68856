"""What users ask of a sweep: cancel, pause, resume, retry. Asked again, nothing happens.

Each raises NotFoundError, or ImpossibleMoveError where the sweep stands somewhere else.
"""

from typing import Any

from sqlalchemy import Connection, Row, select, update

from service.model.run import RunStatus
from service.model.sweep import Sweep, SweepStatus
from service.store.claiming.moves import WAITING, move
from service.store.column_types import now
from service.store.reading import events
from service.store.reading.sweeps import get
from service.store.refusal import ImpossibleMoveError
from service.store.tables import is_running, runs, sweeps


def cancel(connection: Connection, sweep_id: str) -> Sweep:
    """Cancel every run that has not ended: waiting ones at once, running ones by their workers."""
    sweep = get(connection, sweep_id)
    if sweep.status is SweepStatus.CANCELLED:
        return sweep
    _refuse_ended(sweep, "none of its runs is left to cancel")
    row = _row(connection, sweep_id)
    _note(connection, row, "cancelled", cancelled_at=row.cancelled_at or now(), paused_at=None)
    of_sweep = runs.c.sweep_number == row.number
    connection.execute(
        update(runs)
        .where(of_sweep, is_running)
        .values(is_cancelling=True, reason="cancelling: its worker has been told to stop")
    )
    move(connection, of_sweep, WAITING, RunStatus.CANCELLED, "its sweep was cancelled")
    return get(connection, sweep_id)


def pause(connection: Connection, sweep_id: str) -> Sweep:
    """Start none of its runs from now on; those that are running go on to their end."""
    sweep = get(connection, sweep_id)
    _refuse_ended(sweep, "none of its runs is left to start")
    row = _row(connection, sweep_id)
    if row.paused_at is None:
        _note(connection, row, "paused", paused_at=now())
        of_sweep = runs.c.sweep_number == row.number
        move(connection, of_sweep, {RunStatus.QUEUED}, RunStatus.PAUSED, "its sweep is paused")
    return get(connection, sweep_id)


def resume(connection: Connection, sweep_id: str) -> Sweep:
    """Queue its paused runs, those that were paused alone too."""
    sweep = get(connection, sweep_id)
    _refuse_ended(sweep, "none of its runs is left to start")
    row = _row(connection, sweep_id)
    if row.paused_at is not None or sweep.runs.paused:
        _note(connection, row, "resumed", paused_at=None)
        of_sweep = runs.c.sweep_number == row.number
        move(connection, of_sweep, {RunStatus.PAUSED}, RunStatus.QUEUED, "")
    return get(connection, sweep_id)


def retry(connection: Connection, sweep_id: str) -> Sweep:
    """Queue its failed runs again, and only those; what they measured and their attempts stay."""
    sweep = get(connection, sweep_id)
    row = _row(connection, sweep_id)
    if row.cancelled_at is not None:
        raise ImpossibleMoveError(f"sweep {sweep_id} was cancelled: submit it again")
    if sweep.runs.failed:
        _note(connection, row, "retried")
        target = RunStatus.QUEUED if row.paused_at is None else RunStatus.PAUSED
        of_sweep = runs.c.sweep_number == row.number
        move(connection, of_sweep, {RunStatus.FAILED}, target, "tried again on request")
    else:
        _refuse_ended(sweep, "none of its runs has failed")
    return get(connection, sweep_id)


def _refuse_ended(sweep: Sweep, because: str) -> None:
    if sweep.runs.active == 0:
        ended = "was cancelled" if sweep.status is SweepStatus.CANCELLED else "has finished"
        raise ImpossibleMoveError(f"sweep {sweep.id} {ended}: {because}")


def _row(connection: Connection, sweep_id: str) -> Row[Any]:
    return connection.execute(select(sweeps).where(sweeps.c.id == sweep_id)).one()


def _note(connection: Connection, row: Row[Any], change: str, **values: Any) -> None:
    """Write what was asked of the sweep, with its event."""
    if values:
        connection.execute(update(sweeps).where(sweeps.c.number == row.number).values(values))
    events.append(connection, [events.sweep_changed(row.number, row.id, change)])
