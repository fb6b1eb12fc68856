"""The directory that one service works in."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class DataDirInUseError(RuntimeError):
    """Another service works on this data directory."""


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
