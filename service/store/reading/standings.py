"""Results of sweeps for a list: the score of each cell, and a curve of one."""

import math
from collections.abc import Collection, Sequence

from sqlalchemy import Connection, func, select, tuple_

from service.model.standing import CellStanding
from service.store.tables import measurements, runs, sweeps

CELL = (runs.c.sweep_number, runs.c.entry, runs.c.environment)


def of_sweeps(connection: Connection, sweep_ids: Collection[str]) -> list[CellStanding]:
    """Return the cells of sweeps whose runs all have a final score, with its mean."""
    query = (
        select(sweeps.c.id, *CELL, runs.c.environment_version, func.avg(runs.c.score))
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(sweeps.c.id.in_(sweep_ids))
        .group_by(sweeps.c.id, *CELL, runs.c.environment_version)
        .having(func.count() == func.count(runs.c.score))
        .order_by(sweeps.c.id, *CELL)
    )
    return [
        CellStanding(sweep_id, entry, environment, version, mean)
        for sweep_id, _, entry, environment, version, mean in connection.execute(query)
        if math.isfinite(mean)
    ]


def outlines(
    connection: Connection, cells: Sequence[CellStanding], points: int
) -> dict[str, list[float]]:
    """Return about this many means of return_mean of a cell, by its sweep; the latest last."""
    if not cells:
        return {}
    asked = [(cell.sweep_id, cell.entry, cell.environment) for cell in cells]
    query = (
        select(sweeps.c.id, measurements.c.timestep, func.avg(measurements.c.return_mean))
        .join(runs, runs.c.sweep_number == sweeps.c.number)
        .join(measurements, measurements.c.run_number == runs.c.number)
        .where(tuple_(sweeps.c.id, runs.c.entry, runs.c.environment).in_(asked))
        .group_by(sweeps.c.id, measurements.c.timestep)
        .order_by(sweeps.c.id, measurements.c.timestep)
    )
    found: dict[str, list[float]] = {}
    for sweep_id, _, mean in connection.execute(query):
        found.setdefault(sweep_id, []).append(math.nan if mean is None else mean)
    return {
        sweep_id: column[:: -math.ceil(len(column) / points)][::-1]
        for sweep_id, column in found.items()
    }
