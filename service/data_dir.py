"""The directory that one service works in, which its user alone can enter."""

import fcntl
import logging
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from service.refusal import RefusalError

log = logging.getLogger(__name__)

OTHERS = 0o077
"""What other users of the machine may do, of a file's mode."""

LOCK = "lock"
OWN = frozenset({LOCK, "token", "d3pg.sqlite"})
"""Names of which at least one is in every directory that a service has worked in."""


class DataDirError(RefusalError):
    """This data directory cannot be worked in; the text says why."""


@contextmanager
def owned(data_dir: Path) -> Iterator[None]:
    """Make the data directory, for its user alone, and hold it against a second service.

    Raises DataDirError.
    """
    make_private(data_dir)
    with held(data_dir):
        yield


@contextmanager
def held(data_dir: Path) -> Iterator[None]:
    """Hold a data directory against a service. Raises DataDirError.

    The lock goes with the process, however it ends.
    """
    with (data_dir / LOCK).open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DataDirError(
                f"another service works in {data_dir}: stop it, or choose another directory "
                "with D3PG_DATA_DIR (--data-dir)"
            ) from None
        yield


def make_private(data_dir: Path) -> None:
    """Make a directory that its user alone can enter, or make one so. Raises DataDirError.

    A directory that has other files, such as /tmp or a home, is refused instead: others may have
    to enter it.
    """
    try:
        data_dir.mkdir(mode=0o700, parents=True, exist_ok=True)
        mode = data_dir.stat().st_mode
        if mode & OTHERS:
            _refuse_foreign(data_dir, is_shared=bool(mode & stat.S_ISVTX))
            data_dir.chmod(mode & 0o777 & ~OTHERS)
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


def _refuse_foreign(data_dir: Path, *, is_shared: bool) -> None:
    """Raise DataDirError where a directory that others can enter is not a service's."""
    names = {path.name for path in data_dir.iterdir()} - {"lost+found"}
    if is_shared or (names and not names & OWN):
        raise DataDirError(
            f"other users can enter {data_dir}, and it has files that are not a service's: choose "
            "a new or empty directory with D3PG_DATA_DIR (--data-dir)"
        )
