"""Wiring: the one place where store, pool, dispatcher and application meet."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fastapi import FastAPI

from service.app import create_app
from service.checkpoint_removal import CheckpointRemoval
from service.dispatch import Dispatcher
from service.settings import Settings
from service.store.store import Store
from workers.pool_process import PoolProcess, PoolSettings


class DataDirInUseError(RuntimeError):
    """Another service works on this data directory."""


@contextmanager
def wired(settings: Settings) -> Iterator[FastAPI]:
    """Open everything, yield the application, and close everything in order.

    Raises DataDirInUseError, UnsafeSQLiteError.
    """
    with owned(settings.data_dir):
        store = Store.open(settings.store_url)
        try:
            pool = PoolProcess(
                PoolSettings(
                    settings.workers,
                    settings.ray_address,
                    settings.data_dir,
                    settings.checkpoints,
                )
            )
            dispatcher = Dispatcher(store, pool)
            app = create_app(settings, store, dispatcher)
            removal = CheckpointRemoval(store, settings.checkpoints)
            dispatcher.start()
            removal.start()
            try:
                yield app
            finally:
                removal.stop()
                dispatcher.stop()
        finally:
            store.close()


@contextmanager
def owned(data_dir: Path) -> Iterator[None]:
    """Make the data directory, for its user alone, and hold it against a second service.

    The lock goes with the process, however it ends.
    """
    data_dir.mkdir(mode=0o700, parents=True, exist_ok=True)
    with (data_dir / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DataDirInUseError(
                f"another service works in {data_dir}: stop it, or choose another directory "
                "with D3PG_DATA_DIR (--data-dir)"
            ) from None
        yield
