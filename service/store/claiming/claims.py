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
    literal,
    select,
    update,
)

from service.model.claim import CellLimit, Claim
from service.model.run import RunStatus
from service.model.run_name import RunName
from service.store.claiming.turns import Turns, has_room, is_waiting
from service.store.column_types import now
from service.store.reading import events
from service.store.reading.runs import spec_of
from service.store.tables import attempts, is_queued, is_running, runs, sweeps
from workers.messages.assignment import Assignment

Taken = Sequence[Row[Any]]
"""Runs of one cell whose attempts have just begun, in the order of their sweep."""

has_ended = is_running & (runs.c.lease_until < now())

# Of statements that take many runs at once.
of_run = runs.c.number == bindparam("of_run")
of_attempt = (attempts.c.run_number == bindparam("of_run")) & (
    attempts.c.attempt == bindparam("of_attempt")
)

ALONE_AFTER = 2
"""A run that lost this many workers in a row trains alone, so as to take no neighbour with it."""


def claim_all(
    connection: Connection, asked: Sequence[tuple[str, CellLimit]], lease_seconds: float
) -> list[Claim | None]:
    """Claim for each worker queued runs of one cell, as many as are its limit.

    None for those for whom nothing waits any more.
    """
    turns = Turns(connection)
    taken = [
        (worker, _take_next(connection, turns, limit, lease_seconds)) for worker, limit in asked
    ]
    begun = [(worker, rows) for worker, rows in taken if rows]
    if begun:
        _note(connection, turns, begun)
    return [_claim(turns, worker, lease_seconds, rows) if rows else None for worker, rows in taken]


def _claim(turns: Turns, worker: str, lease_seconds: float, rows: Taken) -> Claim:
    claimed = (
        Assignment(str(turns.run_name(row)), row.attempt, spec_of(row), row.environment_version)
        for row in rows
    )
    return Claim(worker, lease_seconds, tuple(claimed))


def _take_next(
    connection: Connection, turns: Turns, limit: CellLimit, lease_seconds: float
) -> Taken:
    """Begin attempts of runs of the sweep whose turn it is; none where nothing waits."""
    while (sweep := turns.next) is not None:
        rows = _take(connection, _cohort(connection, sweep, limit), lease_seconds)
        turns.take(len(rows))
        if rows:
            return rows
    return ()


def _take(connection: Connection, numbers: Sequence[int], lease_seconds: float) -> Taken:
    """Begin an attempt of each run, under a lease."""
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
            may_have_policy=True,
            lease_until=now() + lease_seconds,
            started_at=func.coalesce(runs.c.started_at, now()),
        )
        .returning(runs)
    ).all()
    return sorted(taken, key=lambda row: row.ordinal)


def _cohort(connection: Connection, sweep_number: int, limit: CellLimit) -> list[int]:
    """Return the first waiting run, and others of its cell that were left at the same timestep.

    Those train together.
    """
    of_sweep = runs.c.sweep_number == sweep_number
    first = connection.execute(
        select(runs).where(of_sweep, is_waiting).order_by(runs.c.ordinal).limit(1)
    ).one_or_none()
    if first is None:
        return []
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


def _note(connection: Connection, turns: Turns, taken: Sequence[tuple[str, Taken]]) -> None:
    """Note that sweeps were served, the attempts, and what whoever watches is to know."""
    begun = [row for _, rows in taken for row in rows]
    served = sweeps.c.number.in_({row.sweep_number for row in begun})
    connection.execute(update(sweeps).where(served).values(last_claimed_at=now()))
    opened = ["run_number", "attempt", "worker"]
    for worker, rows in taken:
        of_worker = select(runs.c.number, runs.c.attempt, literal(worker)).where(
            runs.c.number.in_([row.number for row in rows])
        )
        connection.execute(insert(attempts).from_select(opened, of_worker))
    changes = [
        events.run_changed(
            row.sweep_number,
            turns.run_name(row),
            status=RunStatus.RUNNING,
            reason="",
            attempt=row.attempt,
            timestep=row.timestep,
        )
        for row in begun
    ]
    events.append(connection, changes)


def held_runs(connection: Connection, held: Sequence[Claim]) -> list[dict[str, Row[Any]]]:
    """Return, for each claim, the rows of its runs that are still its own, by name."""
    ordinals: dict[str, list[int]] = {}
    for run in chain.from_iterable(claim.runs for claim in held):
        name = RunName.parse(run.run_id)
        ordinals.setdefault(name.sweep_id, []).append(name.ordinal)
    found: dict[str, Row[Any]] = {}
    for sweep_id, wanted in ordinals.items():
        rows = connection.execute(
            held_rows().where(sweeps.c.id == sweep_id, runs.c.ordinal.in_(wanted), is_running)
        )
        found.update({str(RunName(sweep_id, row.ordinal)): row for row in rows})
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


def told(row: Row[Any], status: RunStatus, reason: str, timestep: int) -> events.Change:
    """Return the entry of a held run's new status or reason."""
    return events.run_changed(
        row.sweep_number,
        RunName(row.sweep_id, row.ordinal),
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

    No more runs than the limit are counted, and none of a sweep that may have no more workers.
    """
    alone = case((runs.c.losses >= ALONE_AFTER, runs.c.number), else_=0)
    together = (runs.c.sweep_number, runs.c.cell, runs.c.checkpoint_timestep, alone.label("alone"))
    full = select(sweeps.c.number).where(sweeps.c.max_workers.is_not(None), ~has_room())
    waiting = is_waiting & runs.c.sweep_number.not_in(full)
    found = select(*together).where(waiting).limit(limit).subquery()
    return list(connection.scalars(select(func.count()).select_from(found).group_by(*found.c)))
