"""Recording what a worker says: measurements, the lease, and runs that ended by themselves."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, Row, case, update

from service.claim import Claim
from service.run import RunStatus
from service.store import checkpoints, endings, events, random_returns
from service.store import measurements as points
from service.store.claims import held_runs
from service.store.column_types import now
from service.store.tables import runs
from workers.progress import Activity, Progress


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
        checkpoints.begin(connection, by_seed, progress)
    _go_on(connection, claim, by_seed, progress)
    _measure(connection, held, by_seed, progress)
    checkpoints.note(connection, by_seed, progress.checkpoints)
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
            reached = progress.timestep if seed in in_training(progress, by_seed) else row.timestep
            endings.end(connection, row, RunStatus.CANCELLED, endings.STOPPED, timestep=reached)
    gone = {*progress.finished, *progress.dropped, *(d.seed for d in progress.diverged)}
    return {run_id for run_id, row in held.items() if row.seed not in gone}


def _go_on(
    connection: Connection, claim: Claim, by_seed: Mapping[int, Row[Any]], progress: Progress
) -> None:
    """Renew the lease of all, and note how far those in training have come."""
    numbers = [row.number for row in by_seed.values()]
    lease: dict[str, Any] = {"lease_until": now() + claim.lease_seconds}
    if progress.bytes_per_run:
        lease["memory_bytes"] = progress.bytes_per_run
    if progress.activity is Activity.TRAINING:  # in the same statement: each writes the row anew
        trained = [by_seed[seed].number for seed in in_training(progress, by_seed)]
        is_in_training = runs.c.number.in_(trained)
        lease["timestep"] = case((is_in_training, progress.timestep), else_=runs.c.timestep)
    connection.execute(update(runs).where(runs.c.number.in_(numbers)).values(lease))


def in_training(progress: Progress, by_seed: Mapping[int, Row[Any]]) -> set[int]:
    """Return the seeds that a progress's timestep is of."""
    return set(progress.training or by_seed) & by_seed.keys()


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
