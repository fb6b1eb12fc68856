"""The directory that one service works in, which its user alone can enter."""

import fcntl
import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from service.refusal import RefusalError

log = logging.getLogger(__name__)

OTHERS = 0o077
"""What other users of the machine may do, of a file's mode."""


class DataDirError(RefusalError):
    """This data directory cannot be worked in; the text says why."""


@contextmanager
def owned(data_dir: Path) -> Iterator[None]:
    """Make the data directory, for its user alone, and hold it against a second service.

    The lock goes with the process, however it ends. Raises DataDirError.
    """
    make_private(data_dir)
    with (data_dir / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DataDirError(
                f"another service works in {data_dir}: stop it, or choose another directory "
                "with D3PG_DATA_DIR (--data-dir)"
            ) from None
        yield


def make_private(data_dir: Path) -> None:
    """Make a directory that its user alone can enter, or make one so. Raises DataDirError."""
    try:
        data_dir.mkdir(mode=0o700, parents=True, exist_ok=True)
        if close(data_dir):
            log.warning("Other users could enter %s; now they cannot.", data_dir)
        if not os.access(data_dir, os.W_OK | os.X_OK):
            raise PermissionError(13, "it cannot be written")
    except FileExistsError:
        raise DataDirError(
            f"{data_dir} is a file: choose a directory with D3PG_DATA_DIR (--data-dir)"
        ) from None
    except OSError as error:
        raise DataDirError(
            f"{data_dir} cannot be the data directory ({error.strerror}): choose another with "
            "D3PG_DATA_DIR (--data-dir)"
        ) from error


def close(path: Path) -> bool:
    """Take from other users what they may do with a file or directory; whether there was any."""
    mode = path.stat().st_mode & 0o777
    if mode & OTHERS:
        path.chmod(mode & ~OTHERS)
    return bool(mode & OTHERS)
