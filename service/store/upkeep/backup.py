"""A copy of a SQLite database in use.

`VACUUM INTO` reads one snapshot and blocks no writer. The file gets its name when it is complete
and has reached the disk.
"""

import os
from pathlib import Path

from sqlalchemy import Engine

from service.store.connection import connect
from service.store.upkeep.integrity import check


def backup(source: Engine, file: Path) -> None:
    """Write the backup. Raises FileExistsError, or RuntimeError if the copy is not intact."""
    if file.exists():
        raise FileExistsError(
            f"{file} exists already: name a new file, since a backup overwrites nothing"
        )
    partial = file.with_name(f"{file.name}.partial")
    partial.unlink(missing_ok=True)
    connection = source.raw_connection()
    try:
        connection.cursor().execute("PRAGMA query_only=OFF")  # it takes VACUUM for a write
        connection.cursor().execute("VACUUM INTO ?", (str(partial),))
    finally:
        connection.invalidate()
    _refuse_unless_whole(partial)
    _sync(partial)
    partial.rename(file)
    _sync(file.absolute().parent)


def _refuse_unless_whole(file: Path) -> None:
    engine = connect(f"sqlite:///{file}", "reader")
    try:
        with engine.connect() as connection:
            broken = [each for each in check(connection) if each.faults]
    finally:
        engine.dispose()
    if broken:
        raise RuntimeError(f"{file} is not intact: {broken[0].claim}: {broken[0].faults[0]}")


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
