"""The writer: group commit, and units that fail alone."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest
from sqlalchemy import Connection, Engine, event, text
from sqlalchemy.exc import IntegrityError, OperationalError

from service.store.connection import connect
from service.store.tables import last_commit
from service.store.writer import Writer

Unit = Callable[[Connection], int]


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[Engine]:
    opened = connect(f"sqlite:///{tmp_path / 'numbers.sqlite'}", "writer")
    with opened.begin() as connection:
        connection.execute(text("CREATE TABLE numbers (value INTEGER PRIMARY KEY)"))
        last_commit.create(connection)
    yield opened
    opened.dispose()


@pytest.fixture
def writer(engine: Engine) -> Iterator[Writer]:
    opened = Writer(engine)
    yield opened
    opened.close()


def put(value: int) -> Unit:
    def unit(connection: Connection) -> int:
        connection.execute(text("INSERT INTO numbers VALUES (:value)"), {"value": value})
        return value

    return unit


def numbers(engine: Engine) -> set[int]:
    with engine.connect() as connection:
        return set(connection.scalars(text("SELECT value FROM numbers")))


def write_as_group(writer: Writer, *units: Unit) -> list[Future[int]]:
    """Write the units in one group: they queue up behind one that waits for them."""
    queued = threading.Barrier(2)

    def wait(connection: Connection) -> int:
        del connection
        queued.wait(10)
        return 0

    with ThreadPoolExecutor(len(units) + 1) as pool:
        pool.submit(writer.write, wait)
        while queued.n_waiting == 0:
            pass
        futures = []
        for unit in units:
            futures.append(pool.submit(writer.write, unit))
            while writer._units.qsize() < len(futures):
                pass
        queued.wait(10)
    return futures


def test_gives_the_result_after_the_commit(writer: Writer, engine: Engine) -> None:
    assert writer.write(put(1)) == 1
    assert numbers(engine) == {1}


def test_units_that_wait_share_one_commit(writer: Writer, engine: Engine) -> None:
    commits: list[Connection] = []
    event.listen(engine, "commit", commits.append)
    futures = write_as_group(writer, *(put(value) for value in range(20)))
    assert [future.result() for future in futures] == list(range(20))
    assert len(commits) == 2  # of the one that waited, and of the group
    assert numbers(engine) == set(range(20))


def test_a_refusal_takes_nobody_with_it(writer: Writer, engine: Engine) -> None:
    def refuse(connection: Connection) -> int:
        put(99)(connection)
        raise LookupError("there is no such sweep")

    first, refused, last = write_as_group(writer, put(1), refuse, put(2))
    assert (first.result(), last.result()) == (1, 2)
    with pytest.raises(LookupError, match="no such sweep"):
        refused.result()
    assert numbers(engine) == {1, 2}


def test_a_database_error_takes_nobody_with_it(writer: Writer, engine: Engine) -> None:
    writer.write(put(7))
    first, refused, last = write_as_group(writer, put(1), put(7), put(2))
    assert (first.result(), last.result()) == (1, 2)
    with pytest.raises(IntegrityError):
        refused.result()
    assert numbers(engine) == {1, 2, 7}


def test_a_database_that_ended_the_transaction_itself_loses_no_neighbour(
    writer: Writer, engine: Engine
) -> None:
    """As SQLite does when the disk is full: savepoints are gone, and so is what came before."""

    def end_transaction(connection: Connection) -> int:
        put(99)(connection)
        connection.exec_driver_sql("ROLLBACK")
        raise OperationalError("INSERT", {}, Exception("database or disk is full"))

    first, refused, last = write_as_group(writer, put(1), end_transaction, put(2))
    assert (first.result(), last.result()) == (1, 2)
    with pytest.raises(OperationalError, match="disk is full"):
        refused.result()
    assert numbers(engine) == {1, 2}


def test_nothing_is_acknowledged_when_the_commit_fails(writer: Writer, engine: Engine) -> None:
    def fail(connection: Connection) -> None:
        del connection
        raise OperationalError("COMMIT", {}, Exception("disk I/O error"))

    event.listen(engine, "commit", fail)
    with pytest.raises(OperationalError, match="disk I/O error"):
        writer.write(put(1))
    event.remove(engine, "commit", fail)
    assert numbers(engine) == set()
    assert writer.write(put(2)) == 2


def lose_connection(engine: Engine, *, committed: bool) -> None:
    """Have the next commit lose its connection, after or before it has happened."""

    @event.listens_for(engine, "commit", once=True)
    def lose(connection: Connection) -> None:
        if committed:
            connection.exec_driver_sql("COMMIT")
        lost = Exception("server closed the connection unexpectedly")
        raise OperationalError("COMMIT", {}, lost, connection_invalidated=True)


@pytest.mark.parametrize("committed", [False, True])
def test_a_commit_whose_answer_was_lost_happens_once(
    writer: Writer, engine: Engine, committed: bool
) -> None:
    with engine.begin() as connection:
        connection.execute(text("CREATE TABLE log (value INTEGER)"))

    def append(connection: Connection) -> int:
        connection.execute(text("INSERT INTO log VALUES (1)"))
        return len(connection.execute(text("SELECT * FROM log")).all())

    lose_connection(engine, committed=committed)
    assert writer.write(append) == 1
    assert writer.write(append) == 2


def test_close_commits_what_is_queued(engine: Engine) -> None:
    writer = Writer(engine)
    with ThreadPoolExecutor(8) as pool:
        futures = [pool.submit(writer.write, put(value)) for value in range(8)]
        assert {future.result() for future in futures} == set(range(8))
    writer.close()
    writer.close()
    with pytest.raises(RuntimeError, match="closed"):
        writer.write(put(9))
