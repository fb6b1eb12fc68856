"""The one thread that writes.

Units of work queue up while a commit is under way and are committed together by the next one
(group commit), each inside its own savepoint: a unit that refuses is rolled back alone. A unit's
result is returned after the commit that makes it durable, never before. A commit whose answer was
lost with the connection is neither repeated nor forgotten: the name of the latest commit is written
in the same transaction (the table `last_commit`), so it tells whether that commit happened.
"""

import queue
import secrets
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any, TypeVar

from sqlalchemy import Connection, Engine, insert, select, update
from sqlalchemy.exc import SQLAlchemyError

from service.metrics import WRITE_SECONDS
from service.store.tables import last_commit
from service.store.upkeep.outage import PATIENCE_SECONDS, outlasting

Result = TypeVar("Result")
Unit = Callable[[Connection], Any]
Pending = tuple[Unit, Future[Any]]

GROUP_LIMIT = 256  # units in one transaction, so that none waits long for its neighbours


class Writer:
    """Runs units of work on the engine's connection, one after the other."""

    def __init__(self, engine: Engine) -> None:
        """Start the thread."""
        self._engine = engine
        self._units: queue.SimpleQueue[Pending | None] = queue.SimpleQueue()
        self._is_closed = False
        self.is_failing = False  # whether the latest commit failed
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._work, name="store writer", daemon=True)
        self._thread.start()

    def write(self, unit: Callable[[Connection], Result]) -> Result:
        """Run the unit, wait until it is committed, and return what it returned or raise."""
        future: Future[Result] = Future()
        with WRITE_SECONDS.time():
            with self._lock:
                if self._is_closed:
                    raise RuntimeError("the store is closed")
                self._units.put((unit, future))
            return future.result()

    def close(self) -> None:
        """Commit what is queued, then stop."""
        with self._lock:
            if not self._is_closed:
                self._is_closed = True
                self._units.put(None)
        self._thread.join()

    def _work(self) -> None:
        is_open = True
        while is_open and (first := self._units.get()) is not None:
            group = [first]
            while len(group) < GROUP_LIMIT and not self._units.empty():
                if (another := self._units.get()) is None:
                    is_open = False
                    break
                group.append(another)
            self._commit(group)

    def _commit(self, pending: list[Pending]) -> None:
        """Commit a group. If the database itself failed one unit, each unit is committed alone.

        A database error can end the whole transaction (SQLite rolls it back when the disk is
        full), so nothing may be kept of the group: not the units before it either.
        """
        group = _Group(pending)
        try:
            patience = 0.0 if self._is_closed else PATIENCE_SECONDS
            outlasting(lambda: group.commit(self._engine), patience)
            self.is_failing = False
        except Exception as error:
            self.is_failing = True
            if not group.has_run and len(pending) > 1:
                for alone in pending:
                    self._commit([alone])
                return
            group.outcomes = [(None, error)] * len(pending)
        for (_, future), (result, refusal) in zip(pending, group.outcomes, strict=True):
            if refusal is None:
                future.set_result(result)
            else:
                future.set_exception(refusal)


class _Group:
    """Units that are committed together.

    `commit` can be called again after the connection was lost: the group's name tells whether the
    commit that was under way has happened. No older commit still can, since the writer's connection
    has a single holder.
    """

    def __init__(self, pending: Sequence[Pending]) -> None:
        self.outcomes: list[tuple[Any, Exception | None]] = []
        self.has_run = False
        self._units = [unit for unit, _ in pending]
        self._name = secrets.token_hex(8)

    def commit(self, engine: Engine) -> None:
        """Run the units in one transaction, unless it has been committed already."""
        with engine.begin() as connection:
            if self.has_run and connection.scalar(select(last_commit.c.name)) == self._name:
                return
            self.has_run = False
            self.outcomes = [_attempt(connection, unit) for unit in self._units]
            _name_commit(connection, self._name)
            self.has_run = True


def _name_commit(connection: Connection, name: str) -> None:
    """Name the transaction that is under way."""
    if connection.execute(update(last_commit).values(name=name)).rowcount == 0:  # the first one
        connection.execute(insert(last_commit).values(name=name))


def _attempt(connection: Connection, unit: Unit) -> tuple[Any, Exception | None]:
    """Run one unit in its savepoint. Return what it raises; raise database errors.

    After a database error the savepoint may be gone: the whole transaction is rolled back then.
    """
    savepoint = connection.begin_nested()
    try:
        result = unit(connection)
    except SQLAlchemyError:
        raise
    except Exception as refusal:
        savepoint.rollback()
        return None, refusal
    savepoint.commit()
    return result, None
