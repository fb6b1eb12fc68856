"""Where runs were resumed, which checkpoint each has, and which checkpoints to remove.

Only the worker can say where it resumed a run, since only it has seen whether the checkpoints are
intact. It reports this once, with its fingerprint and all that the run had measured by then. Points
beyond, from an attempt of the same fingerprint, have the same bits as those to come, and stay. An
attempt of another fingerprint had other bits: all its points are deleted in the transaction that
adds those of the checkpoint, so that no curve mixes two attempts.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, delete, func, select, update

from service.model.run import FINAL, RunStatus
from service.model.run_name import RunName
from service.store.at_once import among, update_each
from service.store.claiming.claims import told
from service.store.reading import events
from service.store.tables import attempts, measurements, runs, sweeps
from workers.messages.progress import CheckpointAttempt, Progress, Resumption

Rows = Mapping[int, Row[Any]]
"""Runs by their seed."""
Start = tuple[Row[Any], Mapping[str, Any], Resumption]
"""A run, the fingerprint of its attempt, and where it was resumed."""


def begin(connection: Connection, begun: Sequence[tuple[Rows, Progress]]) -> None:
    """Write the fingerprints of attempts, and where each resumed its runs."""
    starts = [
        (row, _fingerprint(progress, resumed), resumed)
        for held, progress in begun
        for row, resumed in _resumed(held, progress)
    ]
    if not starts:
        return
    _forget_other_bits(connection, starts)
    update_each(
        connection,
        runs,
        ("number",),
        [
            {"number": row.number, "fingerprint": fingerprint, "timestep": resumed.timestep}
            for row, fingerprint, resumed in starts
        ],
        lambda new: {
            "fingerprint": new["fingerprint"],
            **dict.fromkeys(
                ("timestep", "resumed_timestep", "checkpoint_timestep"), new["timestep"]
            ),
        },
    )
    update_each(
        connection,
        attempts,
        ("run_number", "attempt"),
        [
            {
                "run_number": row.number,
                "attempt": row.attempt,
                "fingerprint": fingerprint,
                "resumed_timestep": resumed.timestep,
                "note": resumed.note,
            }
            for row, fingerprint, resumed in starts
        ],
        lambda new: {name: new[name] for name in ("fingerprint", "resumed_timestep", "note")},
    )
    _say(connection, [(row, r.note, r.timestep) for row, _, r in starts if row.attempt > 1])


def _resumed(held: Rows, progress: Progress) -> Iterator[tuple[Row[Any], Resumption]]:
    """Each run with where it was resumed."""
    told = {resumption.seed: resumption for resumption in progress.resumed}
    for seed, row in held.items():
        yield row, told.get(seed, Resumption(seed, 0))


def _fingerprint(progress: Progress, resumed: Resumption) -> Mapping[str, Any]:
    mixed = {"mixed_with": list(resumed.mixed_with)} if resumed.mixed_with else {}
    return {**progress.fingerprint, **mixed}


def _forget_other_bits(connection: Connection, starts: Sequence[Start]) -> None:
    """Delete the points of runs whose earlier attempts had another fingerprint."""
    numbers = [row.number for row, _, _ in starts if row.attempt > 1]
    query = select(runs.c.number, runs.c.fingerprint).where(among(runs.c.number, numbers))
    earlier = {row.number: row.fingerprint for row in connection.execute(query)} if numbers else {}
    others = [
        row.number
        for row, fingerprint, _ in starts
        if (other := earlier.get(row.number)) is not None and other != fingerprint
    ]
    if others:
        connection.execute(delete(measurements).where(among(measurements.c.run_number, others)))


def note(
    connection: Connection, written: Sequence[tuple[Rows, Sequence[CheckpointAttempt]]]
) -> None:
    """Note each run's newest checkpoint, or in its reason why one could not be written.

    The reason keeps the remark on where the run was resumed.
    """
    newest = {
        held[entry.seed].number: (held[entry.seed], entry)
        for held, entries in written
        for entry in entries
        if entry.seed in held
    }
    if not newest:
        return
    whole = [
        {"number": number, "checkpoint_timestep": entry.timestep}
        for number, (_, entry) in newest.items()
        if not entry.problem
    ]
    update_each(
        connection,
        runs,
        ("number",),
        whole,
        lambda new: {"checkpoint_timestep": new["checkpoint_timestep"]},
    )
    notes = _notes(connection, list(newest))
    said = [
        (row, ", ".join(filter(None, (notes[number], entry.problem))), entry.timestep)
        for number, (row, entry) in newest.items()
    ]
    _say(connection, [(row, reason, step) for row, reason, step in said if reason != row.reason])


def _notes(connection: Connection, numbers: Sequence[int]) -> dict[int, str]:
    """The notes of the current attempts of runs, by their number."""
    query = (
        select(attempts.c.run_number, attempts.c.note)
        .join(runs, runs.c.number == attempts.c.run_number)
        .where(among(runs.c.number, numbers))
        .where(attempts.c.attempt == runs.c.attempt)
    )
    return {number: said for number, said in connection.execute(query)}  # noqa: C416


def _say(connection: Connection, said: Sequence[tuple[Row[Any], str, int]]) -> None:
    """Give runs reasons, empty when all is well, unless they are being cancelled."""
    reasons = [(row, reason, step) for row, reason, step in said if not row.is_cancelling]
    if reasons:
        rows = [{"number": row.number, "reason": reason} for row, reason, _ in reasons]
        update_each(connection, runs, ("number",), rows, lambda new: {"reason": new["reason"]})
        told_of = [told(row, RunStatus.RUNNING, reason, step) for row, reason, step in reasons]
        events.append(connection, told_of)


def of_ended(connection: Connection, limit: int) -> dict[str, bool]:
    """Return ended runs that may have files of checkpoints, except those that are kept.

    Each with whether it has a checkpoint of its end, from which a longer run could go on.
    """
    is_whole = (runs.c.status == RunStatus.SUCCEEDED) & (
        runs.c.checkpoint_timestep == runs.c.timesteps
    )
    query = (
        select(sweeps.c.id, runs.c.ordinal, is_whole)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(runs.c.may_have_files, runs.c.status.in_(FINAL), runs.c.kept_bytes.is_(None))
        .limit(limit)
    )
    found = connection.execute(query)
    return {str(RunName(sweep_id, ordinal)): whole for sweep_id, ordinal, whole in found}


def keep(connection: Connection, sizes: Mapping[str, int]) -> None:
    """Write the size of the checkpoints that ended runs keep, unless they go on meanwhile."""
    for run_id, size in sizes.items():
        connection.execute(update(runs).where(has_ended(run_id)).values(kept_bytes=size))


def kept_beyond(connection: Connection, most_bytes: int, limit: int) -> list[str]:
    """Return runs whose checkpoints, with those of all that ended later, exceed the bytes."""
    newest_first = (runs.c.finished_at.desc(), runs.c.number.desc())
    total = func.sum(runs.c.kept_bytes).over(order_by=newest_first)
    kept = (
        select(runs.c.sweep_number, runs.c.ordinal, total.label("total"))
        .where(runs.c.may_have_files, runs.c.status.in_(FINAL), runs.c.kept_bytes.is_not(None))
        .subquery()
    )
    query = (
        select(sweeps.c.id, kept.c.ordinal)
        .join(sweeps, sweeps.c.number == kept.c.sweep_number)
        .where(kept.c.total > most_bytes)
        .limit(limit)
    )
    return [str(RunName(*row)) for row in connection.execute(query)]


def forget(connection: Connection, run_ids: Sequence[str]) -> None:
    """Note that these runs have no files of checkpoints, unless they were tried again meanwhile."""
    values = {"checkpoint_timestep": 0, "may_have_files": False, "kept_bytes": None}
    for run_id in run_ids:
        connection.execute(update(runs).where(has_ended(run_id)).values(values))


def has_ended(run_id: str) -> ColumnElement[bool]:
    """Return the condition that picks a run if it has ended."""
    name = RunName.parse(run_id)
    number = select(sweeps.c.number).where(sweeps.c.id == name.sweep_id).scalar_subquery()
    is_run = (runs.c.sweep_number == number) & (runs.c.ordinal == name.ordinal)
    return is_run & runs.c.status.in_(FINAL)
