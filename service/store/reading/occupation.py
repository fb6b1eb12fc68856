"""What workers train now, and what waits for a worker."""

from typing import Any

from sqlalchemy import Connection, Select, case, func, select

from service.model.occupation import Training, WaitingRuns
from service.model.run_name import RunName
from service.store.column_types import now
from service.store.reading.rows import noun_of
from service.store.tables import attempts, is_queued, is_running, runs, sweeps

MOST_SWEEPS = 100


def training(connection: Connection) -> list[Training]:
    """Return the cohorts that workers train, by the workers' names."""
    rows = connection.execute(_cohorts())
    return [
        noun_of(Training, row, first_run=str(RunName(row.sweep_id, row.ordinal))) for row in rows
    ]


def _cohorts() -> Select[Any]:
    cell = (attempts.c.worker, sweeps.c.id, sweeps.c.name, runs.c.algorithm, runs.c.environment)
    return (
        select(
            *(column.label(name) for column, name in zip(cell, CELL, strict=True)),
            runs.c.entry,
            func.count().label("runs"),
            func.min(runs.c.ordinal).label("ordinal"),
            func.min(attempts.c.started_at).label("since"),
            func.min(runs.c.timestep).label("timestep"),
            func.max(runs.c.timesteps).label("timesteps"),
        )
        .join(
            runs, (runs.c.number == attempts.c.run_number) & (runs.c.attempt == attempts.c.attempt)
        )
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(is_running)
        .group_by(*cell, runs.c.entry)
        .order_by(attempts.c.worker, sweeps.c.id)
    )


CELL = ("worker", "sweep_id", "sweep_name", "algorithm", "environment")


def waiting(connection: Connection) -> list[WaitingRuns]:
    """Return how many runs of which sweeps wait for a worker, in the order of the queue."""
    is_later = runs.c.not_before > now()
    query = (
        select(
            sweeps.c.id.label("sweep_id"),
            sweeps.c.name.label("sweep_name"),
            sweeps.c.priority,
            func.count().label("runs"),
            func.sum(case((is_later, 1), else_=0)).label("later"),
            func.min(runs.c.created_at).label("since"),
        )
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(is_queued)
        .group_by(sweeps.c.number, sweeps.c.id, sweeps.c.name, sweeps.c.priority)
        .order_by(sweeps.c.priority.desc(), sweeps.c.number)
        .limit(MOST_SWEEPS)
    )
    return [noun_of(WaitingRuns, row) for row in connection.execute(query)]
