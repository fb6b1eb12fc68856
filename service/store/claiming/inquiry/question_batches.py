"""A question's batches: the seeds that a sweep is given until its question is answered.

The caller reads the sweep's version first, and then its runs, which have all ended. The batch is
written, or the question settled, only if the sweep still has that version: a run that was queued
again meanwhile, and ended with another result, would be unseen evidence. A repeated call changes
nothing: no seed is in a cell twice.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, insert, select, update

from service.model.run import ACTIVE, RunStatus
from service.store.reading import events
from service.store.reading.sweeps import version
from service.store.tables import is_asking, is_there, runs, sweeps

Cell = tuple[str, int]
"""A task, and the place of an entry."""

COPIED = (
    "sweep_number", "cell", "entry", "algorithm", "environment", "environment_version", "w1", "w2",
    "config", "timesteps",
)  # fmt: skip
"""What the runs of a cell have in common."""


def waiting(connection: Connection) -> list[str]:
    """Return the sweeps whose question or search is open and whose runs have all ended."""
    query = select(sweeps.c.id).where(_waits()).order_by(sweeps.c.number)
    return list(connection.scalars(query))


def go_on(
    connection: Connection, sweep_id: str, seen: str | None, batch: Mapping[Cell, Sequence[int]]
) -> int:
    """Write the missing runs of a batch, or settle the question if there are none.

    Args:
        connection: of the writer.
        sweep_id: the sweep.
        seen: its version (see `sweeps.version`) when the batch was decided on.
        batch: the seeds that cells shall have, including earlier ones.

    Returns:
        The number of runs that were added.
    """
    sweep = waiting_sweep(connection, sweep_id, seen)
    if sweep is None:
        return 0
    added = _rows(connection, sweep, batch)
    if added:
        connection.execute(insert(runs), added)
    close_round(connection, sweep, has_more=bool(added))
    return len(added)


def waiting_sweep(connection: Connection, sweep_id: str, seen: str | None) -> Row[Any] | None:
    """Return the row of a sweep that waits for its next round; else None.

    None, too, if the sweep has changed since it was seen.
    """
    if version(connection, sweep_id) != seen:
        return None
    query = select(sweeps).where(_waits(), sweeps.c.id == sweep_id)
    return connection.execute(query).one_or_none()


def close_round(connection: Connection, sweep: Row[Any], *, has_more: bool) -> None:
    """Write the event of an addition to a sweep, or settle the sweep."""
    if not has_more:
        settled = update(sweeps).where(sweeps.c.number == sweep.number)
        connection.execute(settled.values(question="settled"))
    change = "extended" if has_more else "answered"
    events.append(connection, [events.sweep_changed(sweep.number, sweep.id, change)])


def _waits() -> ColumnElement[bool]:
    is_active = (runs.c.sweep_number == sweeps.c.number) & runs.c.status.in_(ACTIVE)
    return (
        (sweeps.c.question == "open")  # as the index has it
        & is_asking
        & is_there
        & ~select(runs.c.number).where(is_active).exists()
    )


def _rows(
    connection: Connection, sweep: Row[Any], batch: Mapping[Cell, Sequence[int]]
) -> list[dict[str, Any]]:
    """Return the missing runs as rows, numbered after the present ones."""
    own = runs.c.sweep_number == sweep.number
    there = connection.execute(select(runs).where(own).order_by(runs.c.ordinal)).all()
    first = {(row.environment, row.entry): row for row in reversed(there)}
    known = {(row.environment, row.entry, row.seed) for row in there}
    status = RunStatus.QUEUED if sweep.paused_at is None else RunStatus.PAUSED
    missing = [
        (first[cell], seed)
        for cell, seeds in batch.items()
        for seed in seeds
        if (*cell, seed) not in known
    ]
    return [
        {
            **{name: getattr(row, name) for name in COPIED},
            "ordinal": there[-1].ordinal + 1 + place,
            "seed": seed,
            "status": status,
            "reason": "" if status is RunStatus.QUEUED else "its sweep is paused",
        }
        for place, (row, seed) in enumerate(missing)
    ]
