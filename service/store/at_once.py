"""Statements about many rows at once, whose text is the same however many there are.

    query.where(among(runs.c.number, numbers))
    insert_each(connection, attempts, rows)
    update_each(connection, runs, ("number",), rows, lambda new: {"score": new["score"]})

On PostgreSQL their values are passed as arrays, so that a statement is prepared once: a list of
marks (`IN (%s, %s, ...)`) is another text for each length, which SQLAlchemy renders and the server
parses anew. On SQLite `among` takes one JSON list, and a prepared statement runs row by row.
"""

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from sqlalchemy import (
    ARRAY,
    BigInteger,
    ColumnElement,
    Connection,
    Dialect,
    Table,
    Text,
    TypeDecorator,
    bindparam,
    column,
    func,
    insert,
    select,
    update,
)
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement
from sqlalchemy.types import TypeEngine

from service.store.column_types import Exact

Row = Mapping[str, Any]
New = Mapping[str, ColumnElement[Any]]
"""What a row is told, by name, as SQL."""


class Numbers(TypeDecorator[Collection[int]]):
    """Integers: an array on PostgreSQL, a JSON list on SQLite."""

    impl = Text
    cache_ok = True

    def load_dialect_impl(self, dialect: Dialect) -> TypeEngine[Any]:
        """Return the parameter in the form of the database."""
        return dialect.type_descriptor(Text() if dialect.name == "sqlite" else ARRAY(BigInteger()))

    def process_bind_param(self, value: Collection[int] | None, dialect: Dialect) -> Any:
        """Write them."""
        numbers = list(value or ())
        return json.dumps(numbers) if dialect.name == "sqlite" else numbers


class among(FunctionElement[bool]):  # noqa: N801  (reads as the condition it is)
    """The condition that a column of integers has one of these values.

    It has no type: SQLAlchemy compares a function that is a Boolean with 1 on SQLite, which then
    uses no index for it.
    """

    inherit_cache = True

    def __init__(self, compared: ColumnElement[int], numbers: Collection[int]) -> None:
        """Compare a column with any number of integers."""
        super().__init__(compared, bindparam(None, numbers, Numbers(), unique=True))


@compiles(among, "sqlite")
def _sqlite_among(element: among, compiler: SQLCompiler, **words: Any) -> str:
    compared, numbers = (compiler.process(each, **words) for each in element.clauses)
    return f"{compared} IN (SELECT value FROM json_each({numbers}))"  # noqa: S608


@compiles(among, "postgresql")
def _postgresql_among(element: among, compiler: SQLCompiler, **words: Any) -> str:
    compared, numbers = (compiler.process(each, **words) for each in element.clauses)
    return f"{compared} = ANY ({numbers})"


def update_each(
    connection: Connection,
    table: Table,
    keys: Sequence[str],
    rows: Sequence[Row],
    values: Callable[[New], Mapping[str, Any]],
) -> None:
    """Update each row that the keys pick to values that are made of what it is told.

    What a row is told by the name of a column is of that column's type; other names are float64.
    All rows tell the same names.
    """
    if not rows:
        return
    types = {name: _type_of(table, name) for name in rows[0]}
    is_sqlite = connection.dialect.name == "sqlite"
    told = _one_by_one(types) if is_sqlite else _as_arrays(types, rows)
    picked = (table.c[key] == told[key] for key in keys)
    statement = update(table).where(*picked).values(**values(told))
    connection.execute(statement, [_marked(row) for row in rows] if is_sqlite else None)


def insert_each(connection: Connection, table: Table, rows: Sequence[Row]) -> None:
    """Insert rows, which all tell the same columns; the others have their defaults."""
    if not rows:
        return
    if connection.dialect.name == "sqlite":
        connection.execute(insert(table), rows)
        return
    told = _as_arrays({name: _type_of(table, name) for name in rows[0]}, rows)
    connection.execute(insert(table).from_select(list(told), select(*told.values())))


def _one_by_one(types: Mapping[str, TypeEngine[Any]]) -> New:
    """What each row is told, where the statement runs once for each."""
    return {name: bindparam(f"new_{name}", type_=kind) for name, kind in types.items()}


def _marked(row: Row) -> Row:
    """What a row is told, under names that no column has."""
    return {f"new_{name}": value for name, value in row.items()}


def _as_arrays(types: Mapping[str, TypeEngine[Any]], rows: Sequence[Row]) -> New:
    """What all rows are told, as a table."""
    arrays = (
        bindparam(f"new_{name}", [row[name] for row in rows], ARRAY(kind))
        for name, kind in types.items()
    )
    columns = (column(name, kind) for name, kind in types.items())
    table = func.unnest(*arrays).table_valued(*columns, name="told").render_derived()
    return {name: table.c[name] for name in types}


def _type_of(table: Table, name: str) -> TypeEngine[Any]:
    return table.c[name].type if name in table.c else Exact()
