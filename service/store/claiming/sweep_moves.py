"""Moves of a sweep: cancel, pause, resume, retry, uncancel.

A repeated move changes nothing.
"""

from typing import Any

from sqlalchemy import Connection, Row, select, update

from service.model.move import TRANSITIONS, Move
from service.model.sweep import Sweep, SweepStatus
from service.store.claiming.moves import move
from service.store.column_types import now
from service.store.reading import events
from service.store.reading.sweeps import get
from service.store.refusal import ImpossibleMoveError
from service.store.tables import runs, sweeps


def move_sweep(connection: Connection, sweep_id: str, asked: Move) -> Sweep:
    """Move the runs of a sweep.

    Raises NotFoundError, or ImpossibleMoveError for another status of the sweep.
    """
    sweep = get(connection, sweep_id)
    row = _row(connection, sweep_id)
    if (refusal := _refusal(sweep, row, asked)) is not None:
        raise ImpossibleMoveError(refusal)
    if not _would_change(sweep, row, asked):
        return sweep
    _note(connection, row, asked)
    is_paused = _row(connection, sweep_id).paused_at is not None
    reason = TRANSITIONS[asked].of_sweep.reason
    move(connection, asked, runs.c.sweep_number == row.number, reason, is_paused=is_paused)
    return get(connection, sweep_id)


def _refusal(sweep: Sweep, row: Row[Any], asked: Move) -> str | None:
    """Return why a sweep cannot be moved; None if it can be, or was moved already."""
    if asked == "cancel" and sweep.status is SweepStatus.CANCELLED:
        return None
    if asked == "retry" and row.cancelled_at is not None:
        return f"sweep {sweep.id} was cancelled: uncancel it, or submit it again"
    if sweep.runs.active or _at_sources(sweep, asked):
        return None
    if sweep.is_asking and asked != "retry":  # between two batches
        return None
    if asked == "uncancel" and _was_asking(row):
        return None
    ended = "was cancelled" if sweep.status is SweepStatus.CANCELLED else "has finished"
    return f"sweep {sweep.id} {ended}: {TRANSITIONS[asked].none_left}"


def _would_change(sweep: Sweep, row: Row[Any], asked: Move) -> bool:
    """Whether the move was not made before."""
    match asked:
        case "cancel":
            return sweep.status is not SweepStatus.CANCELLED
        case "pause":
            return row.paused_at is None
        case "resume":
            return row.paused_at is not None or sweep.runs.paused > 0
        case "retry":
            return _at_sources(sweep, asked) > 0
        case "uncancel":
            return _at_sources(sweep, asked) > 0 or _was_asking(row)


def _was_asking(row: Row[Any]) -> bool:
    """Whether the sweep was cancelled while its question was open, perhaps between two batches."""
    return row.cancelled_at is not None and row.question == "open"


def _at_sources(sweep: Sweep, asked: Move) -> int:
    """How many of its runs have a status that the move starts from."""
    return sum(getattr(sweep.runs, status.value) for status in TRANSITIONS[asked].sources)


def _note(connection: Connection, row: Row[Any], asked: Move) -> None:
    """Write the move of the sweep, with its event."""
    values: dict[Move, dict[str, Any]] = {
        "cancel": {"cancelled_at": row.cancelled_at or now(), "paused_at": None},
        "pause": {"paused_at": now()},
        "resume": {"paused_at": None},
        "uncancel": {"cancelled_at": None},
    }
    if asked in values:
        of_sweep = sweeps.c.number == row.number
        connection.execute(update(sweeps).where(of_sweep).values(values[asked]))
    change = TRANSITIONS[asked].change
    events.append(connection, [events.sweep_changed(row.number, row.id, change)])


def _row(connection: Connection, sweep_id: str) -> Row[Any]:
    return connection.execute(select(sweeps).where(sweeps.c.id == sweep_id)).one()
