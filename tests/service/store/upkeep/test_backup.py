"""Backups of a SQLite database while it is written to."""

import threading
from pathlib import Path

import pytest

from service.store.connection import connect
from service.store.store import Store
from service.store.upkeep.backup import backup
from tests.service.store.conftest import Fresh
from workers.messages.run_spec import RunSpec


def test_a_backup_is_a_moment_of_a_database_in_use(fresh_sqlite: Fresh, tmp_path: Path) -> None:
    url = fresh_sqlite()
    store, stopping, told = Store.open(url), threading.Event(), list[str]()

    def write() -> None:
        specs = [RunSpec("ddpg", "Pendulum", seed) for seed in range(4)]
        while not stopping.is_set():
            sweep = store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
            told.append(sweep.id)

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    engine = connect(url, "reader")
    known: list[int] = []
    for place in range(3):
        while len(told) < 5 * (place + 1):
            assert writer.is_alive()
        known.append(len(told))
        backup(engine, tmp_path / f"backup-{place}.sqlite")
    stopping.set()
    writer.join()
    engine.dispose()
    store.close()
    for place, acknowledged in enumerate(known):
        copy = Store.open(f"sqlite:///{tmp_path / f'backup-{place}.sqlite'}")
        ids = [sweep.id for sweep in copy.list_sweeps(limit=1000)][::-1]
        copy.close()
        assert len(ids) >= acknowledged
        assert ids == told[: len(ids)]


def test_nothing_is_overwritten(fresh_sqlite: Fresh, tmp_path: Path) -> None:
    engine = connect(fresh_sqlite(), "reader")
    (tmp_path / "kept").write_text("mine")
    with pytest.raises(FileExistsError, match="overwrites nothing"):
        backup(engine, tmp_path / "kept")
    assert (tmp_path / "kept").read_text() == "mine"
    engine.dispose()
