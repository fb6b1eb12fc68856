"""Rows into a table of PostgreSQL by COPY, the cheapest way on both sides."""

from collections.abc import Sequence
from typing import Any

from sqlalchemy import Connection, Table
from sqlalchemy.exc import DBAPIError

TYPES = {"BIGINT": "int8", "DOUBLE PRECISION": "float8", "BYTEA": "bytea"}


def copy_in(connection: Connection, table: Table, rows: Sequence[tuple[Any, ...]]) -> None:
    """Write rows, of all columns in the table's order, in the transaction under way.

    Errors of the driver are raised as SQLAlchemy raises them: SQLAlchemy itself has no support for
    psycopg's COPY.
    """
    driver = connection.dialect.loaded_dbapi
    columns = list(table.columns)
    listed = ", ".join(column.name for column in columns)
    statement = f"COPY {table.name} ({listed}) FROM STDIN (FORMAT BINARY)"
    try:
        cursor: Any = connection.connection.cursor()
        with cursor, cursor.copy(statement) as copy:
            copy.set_types([TYPES[each.type.compile(connection.dialect)] for each in columns])
            for row in rows:
                copy.write_row(row)
    except driver.Error as error:
        raise DBAPIError.instance(
            statement, None, error, driver.Error, dialect=connection.dialect
        ) from error
