"""Where runs were taken up, which checkpoint each has, and whose are to be removed.

The worker alone can say where it took a run up, for it alone has seen whether the checkpoints are
whole. It says so once, together with its fingerprint and all that the run had measured by then.
Points that an attempt of the same fingerprint measured beyond are the same bits as those to come
and stay; an attempt of another fingerprint had other bits, and all its points go in the transaction
that brings those of the checkpoint: a curve is never made of two.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, Row, delete, select, update

from service.run import FINAL, RunStatus
from service.store.claims import tell
from service.store.runs import ordinal_of, run_name
from service.store.tables import attempts, measurements, runs, sweeps
from workers.progress import CheckpointAttempt, Progress, Resumption

Rows = Mapping[int, Row[Any]]
"""Runs by their seed."""


def begin(connection: Connection, held: Rows, progress: Progress) -> None:
    """Note what the bits of an attempt depend on, and where it takes its runs up."""
    resumed = {resumption.seed: resumption for resumption in progress.resumed}
    for seed, row in held.items():
        _begin(connection, row, progress.fingerprint, resumed.get(seed, Resumption(seed, 0)))


def _begin(
    connection: Connection, row: Row[Any], own: Mapping[str, Any], resumption: Resumption
) -> None:
    mixed = {"mixed_with": list(resumption.mixed_with)} if resumption.mixed_with else {}
    fingerprint = {**own, **mixed}
    if row.fingerprint is not None and row.fingerprint != fingerprint:
        connection.execute(delete(measurements).where(measurements.c.run_number == row.number))
    timestep = resumption.timestep
    connection.execute(
        update(runs)
        .where(runs.c.number == row.number)
        .values(
            fingerprint=fingerprint,
            timestep=timestep,
            resumed_timestep=timestep,
            checkpoint_timestep=timestep,
        )
    )
    connection.execute(
        update(attempts)
        .where(attempts.c.run_number == row.number, attempts.c.attempt == row.attempt)
        .values(fingerprint=fingerprint, resumed_timestep=timestep, note=resumption.note)
    )
    if row.attempt > 1:
        _say(connection, row, resumption.note, timestep)


def note(connection: Connection, held: Rows, written: Sequence[CheckpointAttempt]) -> None:
    """Note each run's newest checkpoint, or in its reason why one could not be written.

    The reason goes on saying what there was to say of where the run was taken up.
    """
    newest = {entry.seed: entry for entry in written if entry.seed in held}
    notes = _notes(connection, [held[seed] for seed in newest])
    for seed, attempt in newest.items():
        row = held[seed]
        if not attempt.problem:
            connection.execute(
                update(runs)
                .where(runs.c.number == row.number)
                .values(checkpoint_timestep=attempt.timestep)
            )
        reason = ", ".join(filter(None, (notes[row.number], attempt.problem)))
        if reason != row.reason:
            _say(connection, row, reason, attempt.timestep)


def _notes(connection: Connection, rows: Sequence[Row[Any]]) -> dict[int, str]:
    """The notes of the attempts that the rows are of, by run number."""
    if not rows:
        return {}
    query = (
        select(attempts.c.run_number, attempts.c.note)
        .join(runs, runs.c.number == attempts.c.run_number)
        .where(runs.c.number.in_([row.number for row in rows]))
        .where(attempts.c.attempt == runs.c.attempt)
    )
    return {number: said for number, said in connection.execute(query)}  # noqa: C416


def _say(connection: Connection, row: Row[Any], reason: str, timestep: int) -> None:
    """Give a run a reason, empty when all is well, unless it is being cancelled."""
    if row.is_cancelling:
        return
    connection.execute(update(runs).where(runs.c.number == row.number).values(reason=reason))
    tell(connection, row, RunStatus.RUNNING, reason, timestep)


def of_ended(connection: Connection, limit: int) -> list[str]:
    """Return runs that have ended and may have files of checkpoints."""
    query = (
        select(sweeps.c.id, runs.c.ordinal)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(runs.c.may_have_files, runs.c.status.in_(FINAL))
        .limit(limit)
    )
    return [run_name(sweep_id, ordinal) for sweep_id, ordinal in connection.execute(query)]


def forget(connection: Connection, run_ids: Sequence[str]) -> None:
    """Note that these runs have no files of checkpoints, unless they were tried again meanwhile."""
    for run_id in run_ids:
        number = select(sweeps.c.number).where(sweeps.c.id == run_id.partition("-")[0])
        connection.execute(
            update(runs)
            .where(
                runs.c.sweep_number == number.scalar_subquery(),
                runs.c.ordinal == ordinal_of(run_id),
                runs.c.status.in_(FINAL),
            )
            .values(checkpoint_timestep=0, may_have_files=False)
        )
