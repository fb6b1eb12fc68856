"""Moves of one run: cancel, pause, resume, retry, uncancel.

A repeated move changes nothing.
"""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, Row, select

from service.model.move import TRANSITIONS, Move
from service.model.run import Run, RunStatus
from service.store.claiming.moves import move
from service.store.reading.runs import get, named
from service.store.refusal import ImpossibleMoveError
from service.store.tables import runs, sweeps

_ENDED = {
    RunStatus.SUCCEEDED: "succeeded",
    RunStatus.FAILED: "failed",
    RunStatus.DIVERGED: "diverged",
    RunStatus.CANCELLED: "been cancelled",
}
_ONLY: Mapping[Move, str] = {
    "retry": ": only failed runs are tried again",
    "uncancel": ": only cancelled runs are uncancelled",
}


def move_run(connection: Connection, run_id: str, asked: Move) -> Run:
    """Move one run. Raises NotFoundError, or ImpossibleMoveError for another status."""
    run = get(connection, run_id)
    row = _row(connection, run_id)
    if (refusal := _refusal(run, row, asked)) is not None:
        raise ImpossibleMoveError(refusal)
    chosen = runs.c.number == row.number
    reason = TRANSITIONS[asked].of_run.reason
    move(connection, asked, chosen, reason, is_paused=row.paused_at is not None)
    return get(connection, run_id)


def _refusal(run: Run, row: Row[Any, Any, Any], asked: Move) -> str | None:
    """Return why a run cannot be moved; None if it can be, or was moved already."""
    transition = TRANSITIONS[asked]
    if run.status.is_final and run.status not in transition.sources | {transition.target}:
        already = "" if asked in _ONLY else "already "
        return f"run {run.id} has {already}{_ENDED[run.status]}{_ONLY.get(asked, '')}"
    match asked, run.status:
        case "pause", RunStatus.RUNNING:
            return (
                f"run {run.id} is running: a pause keeps queued runs from starting and stops none"
            )
        case "resume", RunStatus.PAUSED if row.paused_at is not None:
            return f"sweep {run.sweep_id} is paused: resume it, not one of its runs"
        case "retry" | "uncancel", status if status.is_final and row.cancelled_at is not None:
            return f"sweep {run.sweep_id} was cancelled: uncancel it, or submit it again"
    return None


def _row(connection: Connection, run_id: str) -> Row[Any, Any, Any]:
    """Return the run's number and what was asked of its sweep."""
    query = (
        select(runs.c.number, sweeps.c.paused_at, sweeps.c.cancelled_at)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(named(run_id))
    )
    return connection.execute(query).one()
