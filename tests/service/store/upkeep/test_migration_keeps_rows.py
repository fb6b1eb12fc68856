"""Migrations keep rows: of every revision there was, up to the newest and down again.

Revisions are found and tables filled by what the database says of itself, so that a new revision
is covered as it is.
"""

from collections.abc import Mapping
from typing import Any

import pytest
import sqlalchemy as sa
from alembic.script import ScriptDirectory
from sqlalchemy import Column, Connection, Engine, MetaData

from service.store.connection import connect
from service.store.upkeep import migration
from tests.service.store.conftest import Fresh

NEWEST_FIRST = [
    script.revision for script in ScriptDirectory(str(migration.MIGRATIONS)).walk_revisions()
]
STATUS = {1: "running", 2: "queued"}  # of which the first, and no other, has a lease
Rows = dict[str, list[Mapping[str, Any]]]


@pytest.mark.parametrize("revision", NEWEST_FIRST[1:])
def test_rows_outlast_the_way_up_and_down(fresh: Fresh, revision: str) -> None:
    engine = connect(fresh(), "writer")
    migration.downgrade(engine, "base")
    migration.upgrade(engine, revision)
    fill(engine)
    before = rows(engine)
    assert all(len(each) == len(STATUS) for each in before.values())
    migration.upgrade(engine)
    newest = rows(engine)
    migration.downgrade(engine, revision)
    after = rows(engine)
    migration.downgrade(engine, "base")
    migration.upgrade(engine)
    engine.dispose()
    assert common(newest, before) == common(before, newest)
    assert after == before


def test_there_are_earlier_revisions() -> None:
    assert len(NEWEST_FIRST) > 1


def tables(connection: Connection) -> MetaData:
    found = MetaData()
    found.reflect(connection)
    found.remove(found.tables["alembic_version"])
    return found


def fill(engine: Engine) -> None:
    """Write two rows into every table: one with all that can be left out, one without."""
    with engine.begin() as connection:
        for table in tables(connection).sorted_tables:
            for place in STATUS:
                row = {column.name: value(column, place) for column in table.columns}
                connection.execute(table.insert().values(row))


def value(column: Column[Any], place: int) -> Any:
    if column.name == "status":
        return STATUS[place]
    if column.nullable and place > 1:
        return None
    if column.foreign_keys:
        return place
    match column.type:
        case sa.Boolean():
            return place == 1
        case sa.Integer():
            return place
        case sa.Float():
            return place / 3
        case sa.LargeBinary():
            return bytes([0, place])
    return f'{{"{column.name}": {place}}}'


def rows(engine: Engine) -> Rows:
    with engine.connect() as connection:
        return {
            table.name: [
                row._asdict() for row in connection.execute(table.select().order_by(*table.columns))
            ]
            for table in tables(connection).sorted_tables
        }


def common(shown: Rows, other: Rows) -> Rows:
    """Of `shown`, the tables and columns that `other` has too."""
    return {
        name: [{key: row[key] for key in row.keys() & other[name][0].keys()} for row in shown[name]]
        for name in shown.keys() & other.keys()
    }
