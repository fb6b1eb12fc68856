"""A SQLite in memory with this version's tables, whose clock is a test's."""

from collections.abc import Callable

import pysqlite3.dbapi2
from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.pool import StaticPool

from service.store.upkeep.migration import upgrade


def in_memory(clock: Callable[[], float]) -> Engine:
    """Make one that reads the time off this clock."""
    engine = create_engine(
        "sqlite://",
        module=pysqlite3.dbapi2,
        poolclass=StaticPool,
        connect_args={"check_same_thread": False},
    )

    @event.listens_for(engine, "connect")
    def prepare(connection: "pysqlite3.dbapi2.Connection", entry: object) -> None:
        connection.isolation_level = None
        connection.create_function("unixepoch", -1, lambda *_: clock())

    @event.listens_for(engine, "begin")
    def start(connection: Connection) -> None:
        connection.exec_driver_sql("BEGIN")

    upgrade(engine)
    return engine
