"""What finished runs have cost: seconds of one core, by algorithm, environment and settings."""

from collections.abc import Collection

from sqlalchemy import Connection, select

from service.analysis.cost import PastCost
from service.model.run import RunStatus
from service.store.tables import measurements, runs

LATEST_RUNS = 2000


def past(
    connection: Connection, algorithms: Collection[str], environments: Collection[str]
) -> list[PastCost]:
    """Return what the latest succeeded runs of these algorithms and environments have cost."""
    seconds = (
        select(measurements.c.seconds)
        .where(measurements.c.run_number == runs.c.number)
        .order_by(measurements.c.timestep.desc())
        .limit(1)
        .scalar_subquery()
    )
    query = (
        select(
            runs.c.algorithm, runs.c.environment, runs.c.config, runs.c.timesteps,
            seconds.label("seconds"),
        )
        .where(
            runs.c.status == RunStatus.SUCCEEDED,
            runs.c.algorithm.in_(algorithms),
            runs.c.environment.in_(environments),
        )
        .order_by(runs.c.number.desc())
        .limit(LATEST_RUNS)
    )  # fmt: skip
    return [
        PastCost(row.algorithm, row.environment, row.config, row.timesteps, row.seconds)
        for row in connection.execute(query)
        if row.seconds is not None and row.seconds > 0
    ]
