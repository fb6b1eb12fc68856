"""Claiming a cohort, and what is still held of a claim.

A claim raises each run's `attempt` and starts a lease by the database's clock, from the first
instant. Every later write under the claim picks its runs by attempt and status, so that a worker
that was given up changes nothing (fencing), and no run that has ended changes again.
"""

from typing import Any

from sqlalchemy import (
    Connection,
    Row,
    Select,
    exists,
    func,
    insert,
    select,
    update,
)

from service.claim import CellLimit, Claim, ClaimedRun
from service.run import RunStatus
from service.store import events
from service.store.column_types import now
from service.store.runs import run_name, spec_of
from service.store.tables import attempts, is_queued, is_running, runs, sweeps

is_waiting = is_queued & (runs.c.not_before <= now())
has_ended = is_running & (runs.c.lease_until < now())

ALONE_AFTER = 2
"""A run that lost this many workers in a row trains alone, so as to take no neighbour with it."""


def claim(
    connection: Connection, worker: str, lease_seconds: float, limit: CellLimit
) -> Claim | None:
    """Claim queued runs of one cell, as many as are its limit, or None when nothing waits.

    The sweep: highest priority, then fewest running runs, then longest not served, then oldest.
    In it: the first waiting run, and others of its cell that were left at the same timestep, for
    those train together.
    """
    of_sweep = runs.c.sweep_number == sweeps.c.number
    # No EXISTS: PostgreSQL would look at every queued run of every sweep.
    waiting = select(runs.c.number).where(of_sweep, is_waiting).correlate(sweeps).limit(1)
    running = select(func.count()).where(of_sweep, is_running).correlate(sweeps).scalar_subquery()
    sweep = connection.execute(
        select(sweeps.c.number, sweeps.c.id)
        .where(waiting.scalar_subquery().is_not(None))
        .order_by(sweeps.c.priority.desc(), running, sweeps.c.last_claimed_at, sweeps.c.number)
        .limit(1)
    ).one_or_none()
    if sweep is None:
        return None
    numbers = _cohort(connection, sweep.number, limit)
    taken = connection.execute(
        update(runs)
        .where(runs.c.number.in_(numbers), is_queued)
        .values(
            status=RunStatus.RUNNING,
            reason="",
            attempt=runs.c.attempt + 1,
            timestep=runs.c.checkpoint_timestep,
            resumed_timestep=None,
            may_have_files=True,
            lease_until=now() + lease_seconds,
            started_at=func.coalesce(runs.c.started_at, now()),
        )
        .returning(runs)
    ).all()
    taken = sorted(taken, key=lambda row: row.ordinal)
    connection.execute(
        update(sweeps).where(sweeps.c.number == sweep.number).values(last_claimed_at=now())
    )
    connection.execute(
        insert(attempts),
        [{"run_number": row.number, "attempt": row.attempt, "worker": worker} for row in taken],
    )
    events.append(
        connection,
        [
            events.run_changed(
                sweep.number,
                run_name(sweep.id, row.ordinal),
                status=RunStatus.RUNNING,
                reason="",
                attempt=row.attempt,
                timestep=row.timestep,
            )
            for row in taken
        ],
    )
    return Claim(
        worker,
        lease_seconds,
        tuple(
            ClaimedRun(
                run_name(sweep.id, row.ordinal), row.attempt, spec_of(row), row.environment_version
            )
            for row in taken
        ),
    )


def _cohort(connection: Connection, sweep_number: int, limit: CellLimit) -> list[int]:
    of_sweep = runs.c.sweep_number == sweep_number
    first = connection.execute(
        select(runs).where(of_sweep, is_waiting).order_by(runs.c.ordinal).limit(1)
    ).one()
    if first.losses >= ALONE_AFTER:
        return [first.number]
    query = (
        select(runs.c.number)
        .where(
            of_sweep,
            is_waiting,
            runs.c.cell == first.cell,
            runs.c.losses < ALONE_AFTER,
            runs.c.checkpoint_timestep == first.checkpoint_timestep,
        )
        .order_by(runs.c.ordinal)
        .limit(limit(spec_of(first).cell))
    )
    return list(connection.scalars(query))


def held_runs(connection: Connection, claim: Claim) -> dict[str, Row[Any]]:
    """Return the rows of the claim's runs that are still its own, by name."""
    claimed = {run.run_id: run.attempt for run in claim.runs}
    if not claimed:
        return {}
    sweep_id = claim.runs[0].run_id.partition("-")[0]
    ordinals = [int(run_id.partition("-")[2]) for run_id in claimed]
    rows = connection.execute(
        held_rows().where(
            sweeps.c.id == sweep_id,
            runs.c.ordinal.in_(ordinals),
            is_running,
        )
    )
    found = {run_name(sweep_id, row.ordinal): row for row in rows}
    return {run_id: row for run_id, row in found.items() if row.attempt == claimed[run_id]}


def held_rows() -> Select[Any]:
    """Select runs with their sweep's name and whether it is paused."""
    of_sweep = (sweeps.c.id.label("sweep_id"), sweeps.c.paused_at)
    return select(runs, *of_sweep).join(sweeps, sweeps.c.number == runs.c.sweep_number)


def tell(
    connection: Connection, row: Row[Any], status: RunStatus, reason: str, timestep: int
) -> None:
    """Append the event of a held run's new status or reason."""
    entry = events.run_changed(
        row.sweep_number,
        run_name(row.sweep_id, row.ordinal),
        status=status,
        reason=reason,
        attempt=row.attempt,
        timestep=timestep,
    )
    events.append(connection, [entry])


def has_expired(connection: Connection) -> bool:
    """Return whether the lease of any run has ended."""
    return bool(connection.scalar(select(exists().where(has_ended))))


def waiting(connection: Connection) -> int:
    """Return how many runs could be claimed now."""
    query = select(func.count()).where(is_waiting)
    return connection.scalar(query) or 0
