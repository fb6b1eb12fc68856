"""Claiming a cohort, and which runs of a claim are still held.

A claim raises each run's `attempt` and starts a lease by the database's clock, from the first
instant. Every later write under the claim picks its runs by attempt and status, so that a worker
that was given up changes nothing (fencing), and no run that has ended changes again.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

from sqlalchemy import Connection, Row, Select, case, func, select, update

from service.model.claim import CellLimit, Claim
from service.model.run import RunStatus
from service.model.run_name import RunName
from service.store.at_once import among, insert_each
from service.store.claiming.turns import (
    ALONE_AFTER,
    Cohort,
    Line,
    Turns,
    has_room,
    is_waiting,
)
from service.store.column_types import now
from service.store.reading import events
from service.store.reading.runs import spec_of
from service.store.tables import attempts, is_running, runs, sweeps
from workers.messages.assignment import Assignment

has_ended = is_running & (runs.c.lease_until < now())


def claim_all(
    connection: Connection, asked: Sequence[tuple[str, CellLimit]], lease_seconds: float
) -> list[Claim | None]:
    """Claim queued runs of one cell for each worker, up to its limit.

    None for workers for which no run waits any more.
    """
    turns = Turns(connection)
    lines = {
        sweep: Line(connection, sweep, math.ceil(len(asked) / len(turns.sweeps)))
        for sweep in turns.sweeps
    }
    taken = [(worker, _take_next(turns, lines, limit)) for worker, limit in asked]
    begun = [(worker, row) for worker, cohort in taken for row in cohort]
    if begun:
        _begin(connection, [row.number for _, row in begun], lease_seconds)
        _note(connection, turns, begun)
    return [
        _claim(turns, worker, lease_seconds, cohort) if cohort else None for worker, cohort in taken
    ]


def _take_next(turns: Turns, lines: Mapping[int, Line], limit: CellLimit) -> Cohort:
    """Take runs of the sweep whose turn it is; none if nothing waits."""
    while (sweep := turns.next) is not None:
        cohort = lines[sweep].take(limit)
        turns.take(len(cohort))
        if cohort:
            return cohort
    return ()


def _claim(turns: Turns, worker: str, lease_seconds: float, cohort: Cohort) -> Claim:
    claimed = (
        Assignment(str(turns.run_name(row)), row.attempt + 1, spec_of(row), row.environment_version)
        for row in cohort
    )
    return Claim(worker, lease_seconds, tuple(claimed))


def _begin(connection: Connection, numbers: Sequence[int], lease_seconds: float) -> None:
    """Begin an attempt of each run, under a lease."""
    connection.execute(
        update(runs)
        .where(among(runs.c.number, numbers))
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
    )


def _note(connection: Connection, turns: Turns, begun: Sequence[tuple[str, Row[Any]]]) -> None:
    """Write that sweeps were served, the attempts, and the events."""
    served = among(sweeps.c.number, {row.sweep_number for _, row in begun})
    connection.execute(update(sweeps).where(served).values(last_claimed_at=now()))
    insert_each(
        connection,
        attempts,
        [
            {"run_number": row.number, "attempt": row.attempt + 1, "worker": worker}
            for worker, row in begun
        ],
    )
    changes = [
        events.run_changed(
            row.sweep_number,
            turns.run_name(row),
            status=RunStatus.RUNNING,
            reason="",
            attempt=row.attempt + 1,
            timestep=row.checkpoint_timestep,
        )
        for _, row in begun
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
            held_rows().where(sweeps.c.id == sweep_id, among(runs.c.ordinal, wanted), is_running)
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
