"""COPY into PostgreSQL: within the transaction, its errors those that SQLAlchemy raises."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import pytest
from sqlalchemy import Connection
from sqlalchemy.exc import IntegrityError

from service.store.store import Store
from service.store.tables import measurements
from service.store.upkeep.copy_in import copy_in
from tests.service.store.conftest import Fresh
from tests.service.store.postgresql import PostgreSQL
from workers.messages.run_spec import RunSpec

Rows = Sequence[tuple[Any, ...]]


@pytest.fixture
def store(fresh_postgresql: Fresh) -> Iterator[Store]:
    """A store with one run and one set of diagnostics, both number 1."""
    opened = Store.open(fresh_postgresql())
    opened.create_sweep(
        "x", 0, {}, [RunSpec("ddpg", "Pendulum", 0)], environment_versions={"Pendulum": 1}
    )
    opened._writer.write(
        lambda c: c.exec_driver_sql("INSERT INTO diagnostic_sets (names) VALUES ('[]')")
    )
    yield opened
    opened.close()


def row(timestep: int) -> tuple[Any, ...]:
    return (1, timestep, {800: None, 1600: -math.inf}[timestep], 2**62, 0, 1, b"\0\xff")


def stored(store: Store) -> Rows:
    query = "SELECT * FROM measurements ORDER BY timestep"
    return store.read(lambda c: [tuple(r) for r in c.exec_driver_sql(query)])


def test_rows_are_kept_as_they_are(store: Store) -> None:
    rows = [row(800), row(1600)]
    store.write(copy_in, measurements, rows)
    assert stored(store) == rows


def test_a_row_that_is_there_undoes_the_whole_unit(store: Store) -> None:
    store.write(copy_in, measurements, [row(800)])
    with pytest.raises(IntegrityError):
        store.write(copy_in, measurements, [row(1600), row(800)])
    assert stored(store) == [row(800)]


def test_a_connection_that_is_cut_is_made_anew(store: Store, postgresql: PostgreSQL) -> None:
    tries = []

    def cut_at_first(connection: Connection) -> None:
        tries.append(connection.exec_driver_sql("SELECT pg_backend_pid()").scalar())
        if len(tries) == 1:
            postgresql.execute(f"SELECT pg_terminate_backend({tries[0]}, 10000)")
        copy_in(connection, measurements, [row(800)])

    store.write(cut_at_first)
    assert len(set(tries)) == 2
    assert stored(store) == [row(800)]
