"""How a claim ends when its runs do not finish by themselves: failed, stopped, released, lost."""

from typing import Any

from sqlalchemy import Connection, Row, update

from service.claim import Claim
from service.run import RunStatus
from service.store.claims import has_ended, held_rows, held_runs, tell
from service.store.column_types import now
from service.store.retry import RetryPolicy
from service.store.tables import attempts, runs

STOPPED = "cancelled while it was running"


def fail(connection: Connection, claim: Claim, error: str, log_tail: str) -> None:
    """End what is left of the claim as failed: an error in code, which would happen again."""
    error, log_tail = _legible(error), _legible(log_tail)
    reason = error.strip().rpartition("\n")[2] or "failed without a message"
    for row in held_runs(connection, claim).values():
        end(connection, row, RunStatus.FAILED, reason, error=error, log_tail=log_tail)


def release(connection: Connection, claim: Claim, reason: str) -> None:
    """Queue what is left of the claim again, at once: its worker was ended for no fault of it."""
    for row in held_runs(connection, claim).values():
        _queue_again(connection, row, reason, log_tail="", wait_seconds=0.0, losses=row.losses)


def lose(
    connection: Connection, claim: Claim, reason: str, log_tail: str, policy: RetryPolicy
) -> None:
    """Queue what is left of the claim again, after a wait: its worker was lost."""
    reason, log_tail = _legible(reason), _legible(log_tail)
    for row in held_runs(connection, claim).values():
        _lose(connection, row, reason, log_tail, policy)


def lose_expired(connection: Connection, policy: RetryPolicy) -> int:
    """Queue runs whose lease has run out again, after a wait, and return how many there were."""
    expired = connection.execute(held_rows().where(has_ended)).all()
    for row in expired:
        _lose(connection, row, "its worker was not heard of until its lease ended", "", policy)
    return len(expired)


def end(
    connection: Connection,
    row: Row[Any],
    status: RunStatus,
    reason: str,
    *,
    timestep: int | None = None,
    error: str = "",
    log_tail: str = "",
) -> None:
    """End a running run for good."""
    reached = row.timestep if timestep is None else timestep
    _move(connection, row, status, reason, reached)
    connection.execute(update(runs).where(runs.c.number == row.number).values(finished_at=now()))
    _close_attempt(connection, row, status.value, error or reason, log_tail)


def _queue_again(
    connection: Connection,
    row: Row[Any],
    reason: str,
    *,
    log_tail: str,
    wait_seconds: float,
    losses: int,
) -> None:
    if row.is_cancelling:
        end(connection, row, RunStatus.CANCELLED, STOPPED, log_tail=log_tail)
        return
    waiting = RunStatus.QUEUED if row.paused_at is None else RunStatus.PAUSED
    _move(connection, row, waiting, reason, row.timestep)
    connection.execute(
        update(runs)
        .where(runs.c.number == row.number)
        .values(losses=losses, not_before=now() + wait_seconds)
    )
    _close_attempt(connection, row, "lost", reason, log_tail)


def _lose(
    connection: Connection, row: Row[Any], reason: str, log_tail: str, policy: RetryPolicy
) -> None:
    losses = row.losses + 1
    if losses > policy.losses and not row.is_cancelling:
        given_up = f"given up after losing {losses} workers in a row; the last: {reason}"
        end(connection, row, RunStatus.FAILED, given_up, error=reason, log_tail=log_tail)
        return
    wait = policy.wait_seconds(losses)
    _queue_again(connection, row, reason, log_tail=log_tail, wait_seconds=wait, losses=losses)


def _move(
    connection: Connection, row: Row[Any], status: RunStatus, reason: str, timestep: int
) -> None:
    """Take a running run to another status, with its event."""
    connection.execute(
        update(runs)
        .where(runs.c.number == row.number)
        .values(
            status=status,
            reason=reason,
            timestep=timestep,
            lease_until=None,
            is_cancelling=False,
        )
    )
    tell(connection, row, status, reason, timestep)


def _close_attempt(
    connection: Connection, row: Row[Any], outcome: str, error: str, log_tail: str
) -> None:
    connection.execute(
        update(attempts)
        .where(attempts.c.run_number == row.number, attempts.c.attempt == row.attempt)
        .values(outcome=outcome, error=error, log_tail=log_tail, ended_at=now())
    )


def _legible(text: str) -> str:
    """Write as escapes what a program may print and no database holds: NUL, half surrogates."""
    return text.replace("\0", r"\x00").encode(errors="backslashreplace").decode()
