"""Random returns, once per environment version."""

from dataclasses import asdict

from sqlalchemy import Connection, delete, func, insert, select

from service.store.reading.rows import noun_of
from service.store.tables import random_returns
from workers.messages.random_return import RandomReturn


def put(connection: Connection, measured: RandomReturn) -> None:
    """Write one; a later measurement of the same version replaces it."""
    table = random_returns
    same = (table.c.environment == measured.environment) & (table.c.version == measured.version)
    connection.execute(delete(table).where(same))
    connection.execute(insert(table).values(asdict(measured)))


def of_all(connection: Connection) -> dict[tuple[str, int], RandomReturn]:
    """Return every one by (environment, version)."""
    rows = connection.execute(select(random_returns))
    return {(row.environment, row.version): noun_of(RandomReturn, row) for row in rows}


def last_measured_at(connection: Connection) -> float:
    """Return when the newest one was written, 0 when there is none."""
    return connection.scalar(select(func.max(random_returns.c.measured_at))) or 0.0
