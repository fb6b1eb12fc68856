"""The log of a worker: what its process prints and logs, in a file that each cohort restarts."""

import faulthandler
import logging
import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from workers.messages.log_tail import log_tail

LONGEST_BYTES = 2**20
"""A longer file is cut to its end, since it only restarts with the next cohort."""
FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"


class WorkerLog:
    """The file, and how much of it was sent. The clock is for tests."""

    def __init__(self, path: Path, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin the file."""
        self._path = path
        self._clock = clock
        path.parent.mkdir(parents=True, exist_ok=True)
        flags = os.O_CREAT | os.O_WRONLY | os.O_TRUNC | os.O_APPEND
        self._file = os.open(path, flags, 0o600)
        self._told_bytes = 0
        self._told_at = -float("inf")

    def take_output(self) -> None:
        """Send all output of this process to the file, a crash's stack too."""
        os.dup2(self._file, 1)
        os.dup2(self._file, 2)
        faulthandler.enable(sys.__stderr__ or 2)
        logging.basicConfig(level=logging.INFO, format=FORMAT, stream=sys.stderr, force=True)

    def begin(self) -> None:
        """Forget what was printed before."""
        os.ftruncate(self._file, 0)
        self._told_bytes = 0

    def tail(self) -> str:
        """Return the last lines."""
        sys.stdout.flush()
        sys.stderr.flush()
        return log_tail(self._path)

    def news(self, wait_seconds: float) -> str:
        """Return the last lines if there are new ones, and none were sent for so many seconds.

        Otherwise return nothing.
        """
        if self._clock() - self._told_at < wait_seconds:
            return ""
        tail, size = self.tail(), os.fstat(self._file).st_size
        if size == self._told_bytes:
            return ""
        self._told_at, self._told_bytes = self._clock(), size
        if size > LONGEST_BYTES:
            self._cut(tail)
        return tail

    def _cut(self, tail: str) -> None:
        self.begin()
        with suppress(OSError):  # no space is left on the disk
            os.write(self._file, tail.encode(errors="replace"))
        self._told_bytes = os.fstat(self._file).st_size
