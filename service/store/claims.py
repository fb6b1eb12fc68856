"""Claiming a cohort, and what is still held of a claim.

A claim raises each run's `attempt` and starts a lease by the database's clock, from the first
instant. Every later write under the claim picks its runs by attempt and status, so that a worker
that was given up changes nothing (fencing), and no run that has ended changes again.
"""

from collections.abc import Sequence
from itertools import chain
from typing import Any

from sqlalchemy import (
    Connection,
    Row,
    Select,
    bindparam,
    case,
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

# Of statements that take many runs at once.
of_run = runs.c.number == bindparam("of_run")
of_attempt = (attempts.c.run_number == bindparam("of_run")) & (
    attempts.c.attempt == bindparam("of_attempt")
)

ALONE_AFTER = 2
"""A run that lost this many workers in a row trains alone, so as to take no neighbour with it."""


def claim(
    connection: Connection, worker: str, lease_seconds: float, limit: CellLimit
) -> Claim | None:
    """Claim queued runs of one cell, as many as are its limit, or None when nothing waits."""
    sweep = _next_sweep(connection)
    if sweep is None:
        return None
    taken = _take(connection, _cohort(connection, sweep.number, limit), lease_seconds)
    _note(connection, sweep, taken, worker)
    claimed = (
        ClaimedRun(
            run_name(sweep.id, row.ordinal), row.attempt, spec_of(row), row.environment_version
        )
        for row in taken
    )
    return Claim(worker, lease_seconds, tuple(claimed))


def _next_sweep(connection: Connection) -> Row[Any, Any] | None:
    """Find the sweep whose turn it is, of those in which a run waits.

    Highest priority, then fewest running runs, then longest not served, then oldest.
    """
    of_sweep = runs.c.sweep_number == sweeps.c.number
    # No EXISTS: PostgreSQL would look at every queued run of every sweep.
    waiting = select(runs.c.number).where(of_sweep, is_waiting).correlate(sweeps).limit(1)
    running = select(func.count()).where(of_sweep, is_running).correlate(sweeps).scalar_subquery()
    return connection.execute(
        select(sweeps.c.number, sweeps.c.id)
        .where(waiting.scalar_subquery().is_not(None))
        .order_by(sweeps.c.priority.desc(), running, sweeps.c.last_claimed_at, sweeps.c.number)
        .limit(1)
    ).one_or_none()


def _take(
    connection: Connection, numbers: Sequence[int], lease_seconds: float
) -> Sequence[Row[Any]]:
    """Begin an attempt of each run, under a lease; in the order of the sweep."""
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
    return sorted(taken, key=lambda row: row.ordinal)


def _note(
    connection: Connection, sweep: Row[Any, Any], taken: Sequence[Row[Any]], worker: str
) -> None:
    """Note that the sweep was served, the attempts, and what whoever watches is to know."""
    connection.execute(
        update(sweeps).where(sweeps.c.number == sweep.number).values(last_claimed_at=now())
    )
    connection.execute(
        insert(attempts),
        [{"run_number": row.number, "attempt": row.attempt, "worker": worker} for row in taken],
    )
    changes = [
        events.run_changed(
            sweep.number,
            run_name(sweep.id, row.ordinal),
            status=RunStatus.RUNNING,
            reason="",
            attempt=row.attempt,
            timestep=row.timestep,
        )
        for row in taken
    ]
    events.append(connection, changes)


def _cohort(connection: Connection, sweep_number: int, limit: CellLimit) -> list[int]:
    """Return the first waiting run, and others of its cell that were left at the same timestep.

    Those train together.
    """
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


def held_runs(connection: Connection, held: Sequence[Claim]) -> list[dict[str, Row[Any]]]:
    """Return, for each claim, the rows of its runs that are still its own, by name."""
    ordinals: dict[str, list[int]] = {}
    for run in chain.from_iterable(claim.runs for claim in held):
        sweep_id, _, ordinal = run.run_id.partition("-")
        ordinals.setdefault(sweep_id, []).append(int(ordinal))
    found: dict[str, Row[Any]] = {}
    for sweep_id, wanted in ordinals.items():
        rows = connection.execute(
            held_rows().where(sweeps.c.id == sweep_id, runs.c.ordinal.in_(wanted), is_running)
        )
        found.update({run_name(sweep_id, row.ordinal): row for row in rows})
    return [
        {
            run.run_id: row
            for run in claim.runs
            if (row := found.get(run.run_id)) is not None and row.attempt == run.attempt
        }
        for claim in held
    ]


def held_rows() -> Select[Any]:
    """Select what writes need of runs, with their sweep's name and whether it is paused."""
    of_run = (
        runs.c.number,
        runs.c.sweep_number,
        runs.c.ordinal,
        runs.c.seed,
        runs.c.timesteps,
        runs.c.status,
        runs.c.reason,
        runs.c.attempt,
        runs.c.timestep,
        runs.c.is_cancelling,
        runs.c.losses,
    )
    of_sweep = (sweeps.c.id.label("sweep_id"), sweeps.c.paused_at)
    return select(*of_run, *of_sweep).join(sweeps, sweeps.c.number == runs.c.sweep_number)


def told(row: Row[Any], status: RunStatus, reason: str, timestep: int) -> events.Entry:
    """Return the entry of a held run's new status or reason."""
    return events.run_changed(
        row.sweep_number,
        run_name(row.sweep_id, row.ordinal),
        status=status,
        reason=reason,
        attempt=row.attempt,
        timestep=timestep,
    )


def has_expired(connection: Connection) -> bool:
    """Return whether the lease of any run has ended."""
    # No EXISTS: PostgreSQL would look for one among all runs of all time.
    return bool(connection.scalar(select(func.min(runs.c.lease_until) < now()).where(is_running)))


def waiting_cells(connection: Connection, limit: int) -> list[int]:
    """Return of each cell how many runs could be claimed now, together.

    No more runs than the limit are counted.
    """
    alone = case((runs.c.losses >= ALONE_AFTER, runs.c.number), else_=0)
    together = (runs.c.sweep_number, runs.c.cell, runs.c.checkpoint_timestep, alone.label("alone"))
    found = select(*together).where(is_waiting).limit(limit).subquery()
    return list(connection.scalars(select(func.count()).select_from(found).group_by(*found.c)))
