"""Connections to the database: one writer, many readers.

SQLite before 3.51.3 can lose commits or corrupt a database in WAL mode that has two connections
(the WAL-reset bug, sqlite.org/wal.html#walresetbug); it is refused. `synchronous=FULL` makes a
commit survive a power cut. A writing transaction takes its lock as it begins (`BEGIN IMMEDIATE`):
one that began as a reader could fail at its first write whatever `busy_timeout` says.

On PostgreSQL the writer's session holds an advisory lock: there is one writer a database, and when
it has had to connect again, nothing that it began before is still under way. Readers see one
snapshot a transaction, as they do on SQLite.
"""

import os
from collections.abc import Mapping
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import pysqlite3.dbapi2
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.pool import ConnectionPoolEntry

from service.store.refusal import DatabaseInUseError, MissingDriverError, UnsafeSQLiteError
from service.store.unusable import refuse_unfit

SAFE_SQLITE = (3, 51, 3)
SAFE_BACKPORTS = {(3, 44): 6, (3, 50): 7}  # minor version -> first safe patch
BUSY_TIMEOUT_MS = 10_000
READERS = 16
CONNECT_SECONDS = 5
WRITER_LOCK = 0x64337067  # any number, the same for every version of this service
LOCK_NOT_AVAILABLE = "55P03"

Role = Literal["writer", "reader"]
STATEMENTS: Mapping[Role, int] = {"writer": 128, "reader": 0}
"""How many statements a connection of SQLite keeps prepared.

What it keeps takes up its lookaside memory, without which each small value that a query makes is
allocated under a lock: the points of a large sweep take 1.5 times as long.
"""


def connect(url: str | URL, role: Role) -> Engine:
    """Make the engine of one role. The writer's holds one connection; a reader's cannot write.

    Only its user can read a SQLite database, even if others made the file.

    Raises UnsafeSQLiteError for a SQLite that can corrupt the database, MissingDriverError where
    psycopg is not installed; as they connect, both UnfitServerError and the writer's
    DatabaseInUseError.
    """
    address = make_url(url)
    size = {"pool_size": 1 if role == "writer" else READERS, "max_overflow": 0}
    if address.get_backend_name() == "sqlite":
        return _connect_sqlite(address, role, size)
    return _connect_postgresql(address, role, size)


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
        connect_args={
            "timeout": BUSY_TIMEOUT_MS / 1000,
            "check_same_thread": False,
            "cached_statements": STATEMENTS[role],
        },
        **size,
    )
    if role == "writer" and address.database:
        _close_to_others(Path(address.database))
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


def _close_to_others(file: Path) -> None:
    """Make the file, or take away other users' rights; SQLite gives its other files the same."""
    with suppress(OSError):  # whatever is wrong, SQLite will say as it opens the file
        os.close(os.open(file, os.O_RDWR | os.O_CREAT, 0o600))
    for each in (file, *(file.with_name(file.name + suffix) for suffix in ("-wal", "-shm"))):
        with suppress(OSError):
            each.chmod(0o600)


def _connect_postgresql(address: URL, role: Role, size: dict[str, int]) -> Engine:
    if find_spec("psycopg") is None:
        raise MissingDriverError("PostgreSQL needs psycopg: pip install 'd3pg[postgres]'")
    options = {
        "writer": "-c synchronous_commit=on",
        "reader": "-c default_transaction_read_only=on "
        "-c default_transaction_isolation=repeatable\\ read",
    }
    engine = create_engine(
        address.set(drivername="postgresql+psycopg"),
        connect_args={"options": options[role], "connect_timeout": CONNECT_SECONDS},
        **size,
    )
    event.listen(engine, "connect", refuse_unfit, insert=True)  # before SQLAlchemy asks anything
    if role == "writer":
        event.listen(engine, "connect", _lock)
    return engine


def _lock(connection: Any, entry: ConnectionPoolEntry) -> None:
    """Take the lock that goes with the session; one that has just ended may hold it a moment."""
    del entry
    cursor = connection.cursor()
    try:
        cursor.execute(f"SET lock_timeout = '{CONNECT_SECONDS}s'")
        cursor.execute("SELECT pg_advisory_lock(%s)", (WRITER_LOCK,))
        cursor.execute("SET lock_timeout = 0")
        connection.commit()
    except Exception as error:
        connection.close()
        if getattr(error, "sqlstate", None) != LOCK_NOT_AVAILABLE:
            raise
        raise DatabaseInUseError(
            "another service works on this database: stop it, or choose another database with "
            "D3PG_DATABASE_URL (--database-url)"
        ) from None
