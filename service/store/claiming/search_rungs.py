"""A search's rungs: the timesteps that the runs of its best entries are given, rung by rung.

Whoever asks for a rung has seen all runs of the sweep ended, and how many timesteps they had
together: each rung makes these more. The rung is written, or the search settled, only if that is
still so. Asked again after it happened, nothing happens: no rung is written twice, and none of what
was seen before another one. Runs go on from their last checkpoints as those of any sweep that is
extended.
"""

from collections.abc import Mapping

from sqlalchemy import ColumnElement, Connection, and_, func, select

from service.store.claiming.growth import lengthen
from service.store.claiming.question_batches import Cell, close_round, waiting_sweep
from service.store.tables import runs


def go_on(connection: Connection, sweep_id: str, seen: int, wanted: Mapping[Cell, int]) -> int:
    """Give cells the timesteps that they lack, or settle the search where none lacks any.

    Args:
        connection: of the writer.
        sweep_id: the sweep.
        seen: the timesteps that its runs were to have together when the rung was decided on.
        wanted: the timesteps that cells are to have.

    Returns:
        The number of runs that were given more.
    """
    sweep = waiting_sweep(connection, sweep_id)
    if sweep is None:
        return 0
    own = runs.c.sweep_number == sweep.number
    if connection.scalar(select(func.sum(runs.c.timesteps)).where(own)) != seen:
        return 0
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
