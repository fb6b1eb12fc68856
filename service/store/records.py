"""Recording what a worker says: measurements, the lease, and runs that ended by themselves."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, Row, delete, update

from service.claim import Claim
from service.run import RunStatus
from service.store import endings, events, random_returns
from service.store import measurements as points
from service.store.claims import held_runs
from service.store.column_types import now
from service.store.tables import attempts, measurements, runs
from workers.progress import Progress


def record(connection: Connection, claim: Claim, progress: Progress) -> set[str]:
    """Write what a worker said, renew the lease, and return the runs that are still its own.

    Seeds that finished, diverged or were dropped end here, with their last measurements, at once
    or not at all.
    """
    held = held_runs(connection, claim)
    if not held:
        return set()
    by_seed = {row.seed: row for row in held.values()}
    if progress.random_return is not None:
        random_returns.put(connection, progress.random_return)
    if progress.fingerprint:
        _fingerprint(connection, held, progress.fingerprint)
    connection.execute(
        update(runs)
        .where(runs.c.number.in_([row.number for row in held.values()]))
        .values(lease_until=now() + claim.lease_seconds, timestep=progress.timestep)
    )
    _measure(connection, held, by_seed, progress)
    for seed in progress.finished:
        if row := by_seed.get(seed):
            endings.end(connection, row, RunStatus.SUCCEEDED, "", timestep=row.timesteps)
    for divergence in progress.diverged:
        if row := by_seed.get(divergence.seed):
            reason = (
                f"{divergence.quantity} stopped being finite at update {divergence.update}, "
                f"timestep {divergence.timestep}"
            )
            endings.end(connection, row, RunStatus.DIVERGED, reason, timestep=divergence.timestep)
    for seed in progress.dropped:
        if (row := by_seed.get(seed)) and row.is_cancelling:
            endings.end(
                connection, row, RunStatus.CANCELLED, endings.STOPPED, timestep=progress.timestep
            )
    gone = {*progress.finished, *progress.dropped, *(d.seed for d in progress.diverged)}
    return {run_id for run_id, row in held.items() if row.seed not in gone}


def _measure(
    connection: Connection,
    held: Mapping[str, Row[Any]],
    by_seed: Mapping[int, Row[Any]],
    progress: Progress,
) -> None:
    """Add the measurements of runs still held; a run that came further is out of its losses."""
    fresh = points.add(
        connection,
        [(by_seed[m.seed].number, m) for m in progress.measurements if m.seed in by_seed],
    )
    reached: dict[int, list[int]] = {}
    for number, measurement in fresh:
        reached.setdefault(number, []).append(measurement.timestep)
    recovered = [row.number for row in held.values() if row.number in reached and row.losses]
    if recovered:
        connection.execute(update(runs).where(runs.c.number.in_(recovered)).values(losses=0))
    events.append(
        connection,
        [
            events.measured(row.sweep_number, run_id, min(steps), max(steps))
            for run_id, row in held.items()
            if (steps := reached.get(row.number))
        ],
    )


def _fingerprint(
    connection: Connection, held: Mapping[str, Row[Any]], fingerprint: Mapping[str, Any]
) -> None:
    """Note what an attempt's bits depend on.

    An earlier attempt with another fingerprint had other bits: its points go, so that a curve is
    never made of two.
    """
    for row in held.values():
        if row.fingerprint is not None and row.fingerprint != fingerprint:
            connection.execute(delete(measurements).where(measurements.c.run_number == row.number))
        for table, key in ((runs, runs.c.number), (attempts, attempts.c.run_number)):
            query = update(table).where(key == row.number).values(fingerprint=fingerprint)
            if table is attempts:
                query = query.where(attempts.c.attempt == row.attempt)
            connection.execute(query)
