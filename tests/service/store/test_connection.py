"""Connections: which SQLite is safe, how it is opened, who may write."""

from pathlib import Path

import pytest
from sqlalchemy import text
from sqlalchemy.exc import OperationalError

from service.store import connection as connection_module
from service.store.connection import check_sqlite, connect
from service.store.refusal import UnsafeSQLiteError


@pytest.mark.parametrize("version", [(3, 40, 1), (3, 44, 5), (3, 50, 6), (3, 51, 2)])
def test_refuses_versions_with_the_wal_reset_bug(version: tuple[int, int, int]) -> None:
    with pytest.raises(UnsafeSQLiteError, match="pip install --upgrade"):
        check_sqlite(version)


@pytest.mark.parametrize("version", [(3, 44, 6), (3, 50, 7), (3, 51, 3), (3, 53, 4), (4, 0, 0)])
def test_takes_versions_without_it(version: tuple[int, int, int]) -> None:
    check_sqlite(version)


def test_writer_is_durable(tmp_path: Path) -> None:
    engine = connect(f"sqlite:///{tmp_path / 'd3pg.sqlite'}", "writer")
    with engine.connect() as connection:
        assert connection.scalar(text("PRAGMA journal_mode")) == "wal"
        assert connection.scalar(text("PRAGMA synchronous")) == 2  # FULL
        assert connection.scalar(text("PRAGMA foreign_keys")) == 1
    engine.dispose()


def test_writer_locks_as_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    url = f"sqlite:///{tmp_path / 'd3pg.sqlite'}"
    monkeypatch.setattr(connection_module, "BUSY_TIMEOUT_MS", 10)
    writer, rival = connect(url, "writer"), connect(url, "writer")
    with (
        writer.begin(),
        pytest.raises(OperationalError, match="locked"),
        rival.begin(),
    ):
        pass
    writer.dispose()
    rival.dispose()


def test_readers_cannot_write(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'd3pg.sqlite'}"
    writer, reader = connect(url, "writer"), connect(url, "reader")
    with writer.begin() as connection:
        connection.execute(text("CREATE TABLE numbers (value INTEGER)"))
    with reader.connect() as connection, pytest.raises(OperationalError, match="readonly"):
        connection.execute(text("INSERT INTO numbers VALUES (1)"))
    writer.dispose()
    reader.dispose()
