"""How a claim ends when its runs do not finish by themselves: failed, stopped, released, lost.

Each statement takes all runs that end alike, however many.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, func, update

from service.model.claim import Claim
from service.model.run import RunStatus
from service.store.at_once import New, among, update_each
from service.store.claiming.claims import has_ended, held_rows, held_runs, told
from service.store.claiming.logs import legible
from service.store.claiming.retry import RetryPolicy
from service.store.column_types import now
from service.store.reading import events
from service.store.reading.measurements import final_score
from service.store.tables import attempts, runs

STOPPED = "cancelled while it was running"


@dataclass(frozen=True)
class Ending:
    """How a running run stops running.

    outcome   of its attempt
    timestep  that it has reached
    error     what the attempt says; the reason where that is empty
    log_tail  of its worker; what was noted before stays where that is empty
    """

    row: Row[Any]
    status: RunStatus
    reason: str
    outcome: str
    timestep: int
    error: str = ""
    log_tail: str = ""


def fail(connection: Connection, claim: Claim, error: str, log_tail: str = "") -> None:
    """End the runs of the claim as failed: an error in code, which would recur."""
    [held] = held_runs(connection, [claim])
    end(connection, [failed(row, error, log_tail=log_tail) for row in held.values()])


def release(connection: Connection, claim: Claim, reason: str) -> None:
    """Queue the runs of the claim again, at once: the end of their worker was not their fault.

    Here and in `lose`: runs whose cancelling was asked for are cancelled instead.
    """
    [held] = held_runs(connection, [claim])
    _queue_again(connection, [(row, row.losses, 0.0) for row in held.values()], reason, "")


def lose(
    connection: Connection, claim: Claim, reason: str, log_tail: str, policy: RetryPolicy
) -> None:
    """Queue the runs of the claim again, after a wait: their worker was lost."""
    [held] = held_runs(connection, [claim])
    _lose(connection, held.values(), legible(reason), legible(log_tail), policy)


def lose_expired(connection: Connection, policy: RetryPolicy) -> int:
    """Queue runs whose lease has run out again, after a wait, and return how many there were."""
    expired = connection.execute(held_rows().where(has_ended)).all()
    reason = "its worker did not report until its lease ended"
    _lose(connection, expired, reason, "", policy)
    return len(expired)


def ended(
    row: Row[Any],
    status: RunStatus,
    reason: str,
    *,
    timestep: int | None = None,
    error: str = "",
    log_tail: str = "",
) -> Ending:
    """Return the final end of a running run; without a timestep, at its last reported one."""
    reached = row.timestep if timestep is None else timestep
    return Ending(row, status, reason, status.value, reached, error, log_tail)


def failed(row: Row[Any], error: str, *, timestep: int | None = None, log_tail: str = "") -> Ending:
    """Return how a running run ends by an error in code: its reason is the error's last line."""
    error, log_tail = legible(error), legible(log_tail)
    reason = error.strip().rpartition("\n")[2] or "failed without a message"
    return ended(row, RunStatus.FAILED, reason, timestep=timestep, error=error, log_tail=log_tail)


def end(connection: Connection, endings: Sequence[Ending]) -> None:
    """End running runs for good."""
    if endings:
        moved = [_moved(ending) for ending in endings]
        update_each(
            connection,
            runs,
            ("number",),
            moved,
            lambda new: {**_given_up(new), "finished_at": now()},
        )
        _score(connection, [e.row.number for e in endings if e.status is RunStatus.SUCCEEDED])
        _tell(connection, endings)


def _score(connection: Connection, numbers: Sequence[int]) -> None:
    """Write the final scores of runs that have just succeeded."""
    if numbers:
        score = update(runs).where(among(runs.c.number, numbers)).values(score=final_score())
        connection.execute(score)


def _lose(
    connection: Connection,
    rows: Collection[Row[Any]],
    reason: str,
    log_tail: str,
    policy: RetryPolicy,
) -> None:
    """Count one more loss of each, and end those with too many losses."""
    losses = {row.number: row.losses + 1 for row in rows}
    hopeless = [r for r in rows if losses[r.number] > policy.losses and not r.is_cancelling]
    end(
        connection,
        [
            ended(
                row,
                RunStatus.FAILED,
                f"given up after losing {losses[row.number]} workers in a row; the last: {reason}",
                error=reason,
                log_tail=log_tail,
            )
            for row in hopeless
        ],
    )
    again = [
        (row, losses[row.number], policy.wait_seconds(losses[row.number]))
        for row in rows
        if row not in hopeless
    ]
    _queue_again(connection, again, reason, log_tail)


def _queue_again(
    connection: Connection, again: Sequence[tuple[Row[Any], int, float]], reason: str, log_tail: str
) -> None:
    """Queue runs with so many losses to wait for so many seconds; end those being cancelled."""
    stopped = [row for row, _, _ in again if row.is_cancelling]
    end(connection, [ended(r, RunStatus.CANCELLED, STOPPED, log_tail=log_tail) for r in stopped])
    moved: list[Ending] = []
    values: list[dict[str, Any]] = []
    for row, losses, wait_seconds in again:
        if not row.is_cancelling:
            status = RunStatus.QUEUED if row.paused_at is None else RunStatus.PAUSED
            moved.append(Ending(row, status, reason, "lost", row.timestep, log_tail=log_tail))
            values.append({**_moved(moved[-1]), "losses": losses, "wait_seconds": wait_seconds})
    if moved:
        update_each(
            connection,
            runs,
            ("number",),
            values,
            lambda new: {
                **_given_up(new),
                "losses": new["losses"],
                "not_before": now() + new["wait_seconds"],
            },
        )
        _tell(connection, moved)


def _given_up(new: New) -> dict[str, Any]:
    """The values of a run whose training has stopped."""
    told = {name: new[name] for name in ("status", "reason", "timestep")}
    return {**told, "lease_until": None, "is_cancelling": False}


def _moved(ending: Ending) -> dict[str, Any]:
    """The new values of the run's row."""
    return {
        "number": ending.row.number,
        "status": ending.status,
        "reason": ending.reason,
        "timestep": ending.timestep,
    }


def _tell(connection: Connection, endings: Sequence[Ending]) -> None:
    """Close the attempts and append the events."""
    closed = [
        {
            "run_number": ending.row.number,
            "attempt": ending.row.attempt,
            "outcome": ending.outcome,
            "error": ending.error or ending.reason,
            "log_tail": ending.log_tail,
        }
        for ending in endings
    ]
    update_each(
        connection,
        attempts,
        ("run_number", "attempt"),
        closed,
        lambda new: {
            "outcome": new["outcome"],
            "error": new["error"],
            "log_tail": func.coalesce(func.nullif(new["log_tail"], ""), attempts.c.log_tail),
            "ended_at": now(),
        },
    )
    events.append(connection, [told(e.row, e.status, e.reason, e.timestep) for e in endings])
