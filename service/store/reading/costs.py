"""Costs of finished runs: seconds of one core, by algorithm, environment and settings."""

from collections.abc import Collection

from sqlalchemy import Connection, select

from service.analysis.cost import PastCost
from service.model.run import RunStatus
from service.store.reading.packed import own
from service.store.tables import measurements, runs

LATEST_RUNS = 2000


def past(
    connection: Connection, algorithms: Collection[str], environments: Collection[str]
) -> list[PastCost]:
    """Return the costs of the latest succeeded runs of these algorithms and environments."""
    latest = (
        select(measurements.c.packed)
        .where(measurements.c.run_number == runs.c.number)
        .order_by(measurements.c.timestep.desc())
        .limit(1)
        .scalar_subquery()
    )
    query = (
        select(
            runs.c.algorithm, runs.c.environment, runs.c.config, runs.c.timesteps,
            latest.label("latest"),
        )
        .where(
            runs.c.status == RunStatus.SUCCEEDED,
            runs.c.algorithm.in_(algorithms),
            runs.c.environment.in_(environments),
        )
        .order_by(runs.c.number.desc())
        .limit(LATEST_RUNS)
    )  # fmt: skip
    costs = [
        PastCost(
            row.algorithm, row.environment, row.config, row.timesteps, own(row.latest)["seconds"]
        )
        for row in connection.execute(query)
        if row.latest is not None
    ]
    return [cost for cost in costs if cost.seconds > 0]
