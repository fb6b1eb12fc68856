"""Removal of deleted sweeps, step by step, and of what is older than it is kept.

Deleting a sweep hides it at once. Its files and then its rows go afterwards, some runs a
transaction, the last runs first: a service that is killed in between finds the rest in the database
and goes on.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import ColumnElement, Connection, delete, func, select, update

from service.model.run import FINAL
from service.model.run_name import RunName
from service.store.at_once import among
from service.store.claiming.checkpoints import has_ended
from service.store.column_types import now
from service.store.reading import events as log
from service.store.reading.sweeps import get
from service.store.refusal import ImpossibleMoveError
from service.store.tables import (
    attempts,
    diagnoses,
    events,
    measurements,
    runs,
    sweep_names,
    sweeps,
)

EVENTS_AT_ONCE = 20_000


@dataclass(frozen=True)
class Purged:
    """How many rows of which table were deleted."""

    runs: int
    measurements: int


def delete_sweep(connection: Connection, sweep_id: str) -> int:
    """Delete a sweep and return how many runs it had.

    Raises NotFoundError, or ImpossibleMoveError while it has runs that have not ended.
    """
    sweep = get(connection, sweep_id)
    if left := sweep.runs.active:
        raise ImpossibleMoveError(
            f"sweep {sweep_id} has {left} run{'s' * (left > 1)} that have not ended: "
            "cancel it first"
        )
    gone = update(sweeps).where(sweeps.c.id == sweep_id)
    number = connection.scalar(
        gone.values(deleted_at=now(), submission_key=None).returning(sweeps.c.number)
    )
    log.append(connection, [log.sweep_changed(number or 0, sweep_id, "deleted")])
    return sweep.runs.total


def deleted_runs(connection: Connection, limit: int) -> list[str]:
    """Return runs of a deleted sweep, the last ones, whose files and rows are to be deleted."""
    query = (
        select(sweeps.c.id, runs.c.ordinal)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(sweeps.c.number == _oldest_deleted())
        .order_by(runs.c.ordinal.desc())
        .limit(limit)
    )
    return [str(RunName(*row)) for row in connection.execute(query)]


def purge_runs(connection: Connection, run_ids: Sequence[str]) -> Purged:
    """Delete the rows of runs of one deleted sweep."""
    names = [RunName.parse(run_id) for run_id in run_ids]
    sweep = select(sweeps.c.number).where(
        sweeps.c.id == names[0].sweep_id, sweeps.c.deleted_at.is_not(None)
    )
    ordinals = [name.ordinal for name in names]
    of_sweep = runs.c.sweep_number == sweep.scalar_subquery()
    query = select(runs.c.number).where(of_sweep, among(runs.c.ordinal, ordinals))
    numbers = list(connection.scalars(query))
    measured = connection.execute(
        delete(measurements).where(among(measurements.c.run_number, numbers))
    )
    for others in (attempts, diagnoses):
        connection.execute(delete(others).where(among(others.c.run_number, numbers)))
    gone = connection.execute(delete(runs).where(among(runs.c.number, numbers)))
    return Purged(gone.rowcount, measured.rowcount)


def purge_sweep(connection: Connection) -> bool:
    """Delete a deleted sweep that has no runs left, its events first; whether there was one."""
    has_runs = select(runs.c.number).where(runs.c.sweep_number == sweeps.c.number).exists()
    query = select(sweeps.c.number).where(sweeps.c.deleted_at.is_not(None), ~has_runs).limit(1)
    number = connection.scalar(query)
    if number is None:
        return False
    some = select(events.c.id).where(events.c.sweep_number == number).limit(EVENTS_AT_ONCE)
    told = connection.execute(delete(events).where(events.c.id.in_(some)))
    if told.rowcount < EVENTS_AT_ONCE:
        connection.execute(delete(sweep_names).where(sweep_names.c.sweep_number == number))
        connection.execute(delete(sweeps).where(sweeps.c.number == number))
    return True


def purge_events(connection: Connection, older_than_seconds: float) -> int:
    """Delete events that are older, some at a time, and return how many.

    The newest of each sweep stays: answers are tagged with it.
    """
    newest = select(func.max(events.c.id)).group_by(events.c.sweep_number)
    old = (
        select(events.c.id)
        .where(events.c.created_at < now() - older_than_seconds, events.c.id.not_in(newest))
        .order_by(events.c.id)
        .limit(EVENTS_AT_ONCE)
    )
    return connection.execute(delete(events).where(events.c.id.in_(old))).rowcount


def old_policies(connection: Connection, older_than_seconds: float, limit: int) -> list[str]:
    """Return runs that ended so long ago and may have what they learned."""
    query = (
        select(sweeps.c.id, runs.c.ordinal)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(
            runs.c.may_have_policy,
            runs.c.status.in_(FINAL),
            runs.c.finished_at < now() - older_than_seconds,
        )
        .limit(limit)
    )
    return [str(RunName(*row)) for row in connection.execute(query)]


def forget_policies(connection: Connection, run_ids: Sequence[str]) -> None:
    """Note that these runs have no policies, unless they were queued again meanwhile."""
    for run_id in run_ids:
        connection.execute(update(runs).where(has_ended(run_id)).values(may_have_policy=False))


def _oldest_deleted() -> ColumnElement[int]:
    deleted = select(func.min(sweeps.c.number)).where(sweeps.c.deleted_at.is_not(None))
    return deleted.scalar_subquery()
