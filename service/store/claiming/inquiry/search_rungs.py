"""A search's rungs: the timesteps that the runs of its best entries are given, rung by rung.

A rung is written, or the search settled, only if the sweep is as it was seen, as with a batch of a
question. Runs go on from their last checkpoints as those of any sweep that is extended.
"""

from collections.abc import Mapping

from sqlalchemy import ColumnElement, Connection, and_, func, select

from service.store.claiming.growth import lengthen
from service.store.claiming.inquiry.question_batches import Cell, close_round, waiting_sweep
from service.store.tables import runs


def go_on(
    connection: Connection, sweep_id: str, seen: str | None, wanted: Mapping[Cell, int]
) -> int:
    """Give cells their missing timesteps, or settle the search if none are missing.

    Args:
        connection: of the writer.
        sweep_id: the sweep.
        seen: its version (see `sweeps.version`) when the rung was decided on.
        wanted: the timesteps that cells shall have.

    Returns:
        The number of runs that were given more.
    """
    sweep = waiting_sweep(connection, sweep_id, seen)
    if sweep is None:
        return 0
    own = runs.c.sweep_number == sweep.number
    longer = 0
    for cell, timesteps in wanted.items():
        short = and_(own, _of(cell), runs.c.timesteps < timesteps)
        longer += connection.scalar(select(func.count()).where(short)) or 0
        lengthen(connection, sweep, short, timesteps, "it is among the best of its search")
    close_round(connection, sweep, has_more=longer > 0)
    return longer


def _of(cell: Cell) -> ColumnElement[bool]:
    environment, entry = cell
    return and_(runs.c.environment == environment, runs.c.entry == entry)
