"""Recording the reports of workers: measurements, the lease, and runs that ended by themselves.

Reports of many workers are written together, statement by statement: rows alone have a cost.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, func, update

from service.model.claim import Claim
from service.model.run import RunStatus
from service.model.run_name import RunName
from service.store.at_once import among, update_each
from service.store.claiming import checkpoints, endings, logs
from service.store.claiming.claims import held_runs
from service.store.claiming.endings import Ending
from service.store.column_types import now
from service.store.reading import events, random_returns
from service.store.reading import measurements as points
from service.store.tables import runs
from workers.messages.progress import Activity, Progress


@dataclass(frozen=True)
class Heard:
    """The report of a worker, and the runs of its claim that it still holds: by name, by seed."""

    claim: Claim
    progress: Progress
    held: Mapping[str, Row[Any]]
    by_seed: Mapping[int, Row[Any]]

    @property
    def in_training(self) -> set[int]:
        """The seeds that the progress's timestep is of."""
        return set(self.progress.training or self.by_seed) & self.by_seed.keys()


def record_all(connection: Connection, said: Sequence[tuple[Claim, Progress]]) -> list[set[str]]:
    """Write reports of workers, renew leases, and return the runs that each still holds.

    Seeds that finished, diverged or were dropped end here, with their last measurements, at once
    or not at all. No run is in two of the claims.
    """
    held = held_runs(connection, [claim for claim, _ in said])
    heard = [
        Heard(claim, progress, rows, {row.seed: row for row in rows.values()})
        for (claim, progress), rows in zip(said, held, strict=True)
    ]
    for each in heard:
        if each.held and each.progress.random_return is not None:
            random_returns.put(connection, each.progress.random_return)
    checkpoints.begin(
        connection, [(h.by_seed, h.progress) for h in heard if h.progress.fingerprint]
    )
    _go_on(connection, heard)
    _measure(connection, heard)
    checkpoints.note(connection, [(each.by_seed, each.progress.checkpoints) for each in heard])
    logs.note(
        connection,
        [(h.held.values(), h.progress.log_tail) for h in heard if h.held and h.progress.log_tail],
    )
    endings.end(connection, [ending for each in heard for ending in _endings(each)])
    return [_going_on(each) for each in heard]


def _go_on(connection: Connection, heard: Sequence[Heard]) -> None:
    """Renew the lease of all, and write the timesteps of those in training."""
    update_each(
        connection,
        runs,
        ("number",),
        [row for each in heard for row in _renewals(each)],
        lambda new: {
            "lease_until": now() + new["lease_seconds"],
            "timestep": func.coalesce(new["timestep"], runs.c.timestep),
            "memory_bytes": func.coalesce(new["memory_bytes"], runs.c.memory_bytes),
        },
    )


def _renewals(heard: Heard) -> Iterator[Mapping[str, Any]]:
    """The new values of each run's row; None leaves a value as it is."""
    progress = heard.progress
    trained = heard.in_training if progress.activity is Activity.TRAINING else set()
    for seed, row in heard.by_seed.items():
        yield {
            "number": row.number,
            "lease_seconds": heard.claim.lease_seconds,
            "timestep": progress.timestep if seed in trained else None,
            "memory_bytes": progress.bytes_per_run or None,
        }


def _measure(connection: Connection, heard: Sequence[Heard]) -> None:
    """Add the measurements of runs still held; progress resets the losses of a run."""
    fresh = points.add(
        connection,
        [
            (each.by_seed[m.seed].number, m)
            for each in heard
            for m in each.progress.measurements
            if m.seed in each.by_seed
        ],
    )
    reached: dict[int, list[int]] = {}
    for number, measurement in fresh:
        reached.setdefault(number, []).append(measurement.timestep)
    rows = {row.number: row for each in heard for row in each.held.values()}
    if recovered := [number for number in reached if rows[number].losses]:
        connection.execute(update(runs).where(among(runs.c.number, recovered)).values(losses=0))
    events.append(connection, [change for each in heard for change in _measured(each, reached)])


def _measured(heard: Heard, reached: Mapping[int, Sequence[int]]) -> Iterator[events.Change]:
    """The events of a report: one entry for all runs at the same timestep."""
    spans: dict[tuple[int, int], list[Row[Any]]] = {}
    for row in heard.held.values():
        if steps := reached.get(row.number):
            spans.setdefault((min(steps), max(steps)), []).append(row)
    for (first, last), rows in spans.items():
        names = [RunName(row.sweep_id, row.ordinal) for row in rows]
        yield events.measured(rows[0].sweep_number, names, first, last)


def _endings(heard: Heard) -> list[Ending]:
    """The ends of runs that ended by themselves or were dropped."""
    progress, by_seed = heard.progress, heard.by_seed
    ends = [
        endings.ended(row, RunStatus.SUCCEEDED, "", timestep=row.timesteps)
        for seed in progress.finished
        if (row := by_seed.get(seed))
    ]
    for divergence in progress.diverged:
        if row := by_seed.get(divergence.seed):
            reason = (
                f"{divergence.quantity} stopped being finite at update {divergence.update}, "
                f"timestep {divergence.timestep}"
            )
            step = divergence.timestep
            ends.append(endings.ended(row, RunStatus.DIVERGED, reason, timestep=step))
    ends += [
        endings.failed(row, failure.error, timestep=failure.timestep)
        for failure in progress.failed
        if (row := by_seed.get(failure.seed))
    ]
    for seed in progress.dropped:
        if (row := by_seed.get(seed)) and row.is_cancelling:
            step = progress.timestep if seed in heard.in_training else row.timestep
            ends.append(endings.ended(row, RunStatus.CANCELLED, endings.STOPPED, timestep=step))
    return ends


def _going_on(heard: Heard) -> set[str]:
    """The runs that the worker shall train further."""
    gone = heard.progress.gone
    return {run_id for run_id, row in heard.held.items() if row.seed not in gone}
