"""Copying one database into another, empty one, verified by counts and hashes.

One transaction at each end: the source is read as it stood at one moment, and the target holds
everything or nothing. A table's hash is the SHA-256 of its rows in the order of their keys, every
value written so that equal text means equal bits. What was written is read back and hashed before
it is committed. The sign of a zero is the one thing that SQLite does not keep.
"""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import (
    Column,
    Connection,
    Engine,
    MetaData,
    Table,
    Text,
    TypeDecorator,
    collate,
    func,
    insert,
    select,
)

from service.store.refusal import TransferError
from service.store.tables import metadata

PAGE = 2000

Tell = Callable[[str, int, int], None]
"""Receives a table, the number of its rows that are copied, and the number that it has."""


@dataclass(frozen=True)
class CopiedTable:
    """A table that is equal at both ends."""

    name: str
    rows: int
    sha256: str


def transfer(source: Engine, target: Engine, tell: Tell) -> list[CopiedTable]:
    """Copy every row and return the verified tables. Both ends have this version's tables.

    Raises TransferError, with nothing written, if the target is not empty or does not return what
    was written.
    """
    with source.connect() as reader, target.begin() as writer:
        tables = [_as_stored(table) for table in metadata.sorted_tables]
        _refuse_unless_empty(writer, tables)
        for table in tables:
            _copy(reader, writer, table, tell)
        if writer.dialect.name == "postgresql":
            _continue_numbering(writer)
        return [_prove(reader, writer, table) for table in tables]


def _as_stored(table: Table) -> Table:
    """Return the table with its columns as the database holds them: nothing is decoded."""
    columns = []
    for column in table.columns:
        kind = column.type.impl if isinstance(column.type, TypeDecorator) else column.type
        columns.append(Column(column.name, kind, primary_key=column.primary_key))
    return Table(table.name, MetaData(), *columns)


def _refuse_unless_empty(writer: Connection, tables: Sequence[Table]) -> None:
    for table in tables:
        if (rows := _count(writer, table)) > 0:
            raise TransferError(
                f"the target is not empty: its table {table.name} has {rows} rows. "
                "Copy into a new database"
            )


def _copy(reader: Connection, writer: Connection, table: Table, tell: Tell) -> None:
    total, copied = _count(reader, table), 0
    names = table.columns.keys()
    for page in _pages(reader, table):
        rows = [dict(zip(names, row, strict=True)) for row in page]
        writer.execute(insert(table), rows)
        copied += len(rows)
        tell(table.name, copied, total)


def _continue_numbering(writer: Connection) -> None:
    """Make PostgreSQL number new rows after the last copied one; SQLite does so by itself."""
    for table in metadata.sorted_tables:
        column = table.autoincrement_column
        if column is not None and (last := writer.scalar(select(func.max(column)))) is not None:
            sequence = func.pg_get_serial_sequence(table.name, column.name)
            writer.execute(select(func.setval(sequence, last)))


def _prove(reader: Connection, writer: Connection, table: Table) -> CopiedTable:
    (rows, digest), copied = _digest(reader, table), _digest(writer, table)
    if copied != (rows, digest):
        raise TransferError(
            f"table {table.name} differs at the target: {rows} rows with SHA-256 {digest} became "
            f"{copied[0]} rows with {copied[1]}. Nothing was kept"
        )
    return CopiedTable(table.name, rows, digest)


def _digest(connection: Connection, table: Table) -> tuple[int, str]:
    rows, digest = 0, hashlib.sha256()
    for page in _pages(connection, table):
        rows += len(page)
        for row in page:
            values = [value + 0.0 if isinstance(value, float) else value for value in row]
            digest.update(f"{values!r}\n".encode())
    return rows, digest.hexdigest()


def _pages(connection: Connection, table: Table) -> Iterator[Sequence[Any]]:
    # By bytes, as SQLite does it: a language's order of letters may differ between the ends.
    collation = {"sqlite": "BINARY", "postgresql": "C"}[connection.dialect.name]
    keys = [
        collate(key, collation) if isinstance(key.type, Text) else key for key in table.primary_key
    ]
    query = select(table).order_by(*keys).execution_options(stream_results=True)
    with connection.execute(query) as result:
        yield from result.partitions(PAGE)


def _count(connection: Connection, table: Table) -> int:
    return connection.scalar(select(func.count()).select_from(table)) or 0
