"""What users ask of one run: cancel, pause, resume, retry. Asked again, nothing happens.

Each raises NotFoundError, or ImpossibleMoveError where the run stands somewhere else.
"""

from typing import Any

from sqlalchemy import Connection, Row, select, update

from service.model.run import Run, RunStatus
from service.store.claiming.moves import WAITING, move
from service.store.reading.runs import get, named
from service.store.refusal import ImpossibleMoveError
from service.store.tables import runs, sweeps

_ENDED = {
    RunStatus.SUCCEEDED: "succeeded",
    RunStatus.FAILED: "failed",
    RunStatus.DIVERGED: "diverged",
    RunStatus.CANCELLED: "been cancelled",
}


def cancel(connection: Connection, run_id: str) -> Run:
    """Cancel a run: at once while it waits, by its worker while it runs."""
    run = get(connection, run_id)
    if run.status is RunStatus.CANCELLED or run.is_cancelling:
        return run
    _refuse_ended(run)
    chosen = runs.c.number == _row(connection, run_id).number
    if run.status is RunStatus.RUNNING:
        connection.execute(
            update(runs)
            .where(chosen)
            .values(is_cancelling=True, reason="cancelling: its worker has been told to stop")
        )
    else:
        move(connection, chosen, WAITING, RunStatus.CANCELLED, "cancelled before it started")
    return get(connection, run_id)


def pause(connection: Connection, run_id: str) -> Run:
    """Keep a queued run from being started."""
    run = get(connection, run_id)
    _refuse_ended(run)
    if run.status is RunStatus.RUNNING:
        raise ImpossibleMoveError(
            f"run {run_id} is running: a pause keeps queued runs from starting and stops none"
        )
    chosen = runs.c.number == _row(connection, run_id).number
    move(connection, chosen, {RunStatus.QUEUED}, RunStatus.PAUSED, "paused")
    return get(connection, run_id)


def resume(connection: Connection, run_id: str) -> Run:
    """Queue a paused run."""
    run = get(connection, run_id)
    _refuse_ended(run)
    row = _row(connection, run_id)
    if run.status is RunStatus.PAUSED and row.paused_at is not None:
        raise ImpossibleMoveError(f"sweep {run.sweep_id} is paused: resume it, not one of its runs")
    chosen = runs.c.number == row.number
    move(connection, chosen, {RunStatus.PAUSED}, RunStatus.QUEUED, "")
    return get(connection, run_id)


def retry(connection: Connection, run_id: str) -> Run:
    """Queue a failed run again; what it measured and its attempts stay."""
    run = get(connection, run_id)
    if not run.status.is_final:
        return run
    if run.status is not RunStatus.FAILED:
        raise ImpossibleMoveError(
            f"run {run_id} has {_ENDED[run.status]}: only failed runs are tried again"
        )
    row = _row(connection, run_id)
    if row.cancelled_at is not None:
        raise ImpossibleMoveError(f"sweep {run.sweep_id} was cancelled: submit it again")
    target = RunStatus.QUEUED if row.paused_at is None else RunStatus.PAUSED
    chosen = runs.c.number == row.number
    move(connection, chosen, {RunStatus.FAILED}, target, "tried again on request")
    return get(connection, run_id)


def _refuse_ended(run: Run) -> None:
    if run.status.is_final:
        raise ImpossibleMoveError(f"run {run.id} has already {_ENDED[run.status]}")


def _row(connection: Connection, run_id: str) -> Row[Any, Any, Any]:
    """Return the run's number and what was asked of its sweep."""
    query = (
        select(runs.c.number, sweeps.c.paused_at, sweeps.c.cancelled_at)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(named(run_id))
    )
    return connection.execute(query).one()
