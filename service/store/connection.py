"""Connections to the database: one writer, many readers.

SQLite before 3.51.3 can lose commits or corrupt a database in WAL mode that has two connections
(the WAL-reset bug, sqlite.org/wal.html#walresetbug); it is refused. `synchronous=FULL` makes a
commit survive a power cut. A writing transaction takes its lock as it begins (`BEGIN IMMEDIATE`):
one that began as a reader could fail at its first write whatever `busy_timeout` says.
"""

from typing import Any, Literal

import pysqlite3.dbapi2
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.pool import ConnectionPoolEntry

from service.store.refusal import UnsafeSQLiteError

SAFE_SQLITE = (3, 51, 3)
SAFE_BACKPORTS = {(3, 44): 6, (3, 50): 7}  # minor version -> first safe patch
BUSY_TIMEOUT_MS = 10_000
READERS = 16

Role = Literal["writer", "reader"]


def connect(url: str, role: Role) -> Engine:
    """Make the engine of one role. The writer's holds one connection; a reader's cannot write.

    Raises UnsafeSQLiteError for a SQLite that can corrupt the database.
    """
    address = make_url(url)
    size = {"pool_size": 1 if role == "writer" else READERS, "max_overflow": 0}
    if address.get_backend_name() == "sqlite":
        return _connect_sqlite(address, role, size)
    options = "" if role == "writer" else "-c default_transaction_read_only=on"
    return create_engine(address, connect_args={"options": options}, pool_pre_ping=True, **size)


def check_sqlite(version: tuple[int, int, int]) -> None:
    """Raise UnsafeSQLiteError unless this version of SQLite is free of the WAL-reset bug."""
    backport = SAFE_BACKPORTS.get(version[:2])
    if version >= SAFE_SQLITE or (backport is not None and version[2] >= backport):
        return
    raise UnsafeSQLiteError(
        f"SQLite {'.'.join(map(str, version))} can corrupt a database in WAL mode; "
        f"{'.'.join(map(str, SAFE_SQLITE))} or later is needed. "
        "Install a newer one: pip install --upgrade 'pysqlite3>=0.6.1'"
    )


def _connect_sqlite(address: URL, role: Role, size: dict[str, int]) -> Engine:
    check_sqlite(pysqlite3.dbapi2.sqlite_version_info)
    engine = create_engine(
        address,
        module=pysqlite3.dbapi2,
        connect_args={"timeout": BUSY_TIMEOUT_MS / 1000, "check_same_thread": False},
        **size,
    )
    begin = "BEGIN IMMEDIATE" if role == "writer" else "BEGIN"

    @event.listens_for(engine, "connect")
    def prepare(connection: Any, entry: ConnectionPoolEntry) -> None:
        del entry
        connection.isolation_level = None  # the driver begins nothing by itself; `start` does
        connection.execute("PRAGMA foreign_keys=ON")
        connection.execute("PRAGMA synchronous=FULL")
        if role == "writer":
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA journal_size_limit=67108864")
        else:
            connection.execute("PRAGMA query_only=ON")

    @event.listens_for(engine, "begin")
    def start(connection: Connection) -> None:
        connection.exec_driver_sql(begin)

    return engine
