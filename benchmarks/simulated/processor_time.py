"""Processor time of the calling thread, of the store's writer and of PostgreSQL's sessions.

It does not depend on how busy the machine is, except through the caches, and it contains no
waiting: neither for the disk (`fsync`) nor for communication between processes.
"""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SESSION = b"postgres: d3pg"
"""Prefix of the titles of processes that serve the user of `tests/service/store/postgresql.py`."""


class ProcessorTime:
    """Sums, from now on, the processor time spent on the open store."""

    def __init__(self, postgres: int | None) -> None:
        """`postgres` is the server's process; None if the database runs in our own threads."""
        [writer] = [each for each in threading.enumerate() if each.name == "store writer"]
        assert writer.ident is not None
        self._writer_clock = time.pthread_getcpuclockid(writer.ident)
        self._postgres = postgres
        self._sessions: dict[int, float] = {}
        self._uncounted = 0.0
        self._service_from = self._database_from = 0.0
        self._service_from, self._database_from = self.service, self.database

    @property
    def service(self) -> float:
        """Seconds of the calling thread and of the writer, without the uncounted ones."""
        own = time.thread_time() - self._uncounted
        return own + time.clock_gettime(self._writer_clock) - self._service_from

    @property
    def database(self) -> float:
        """Seconds of PostgreSQL's sessions; without PostgreSQL, `service` includes the database."""
        if self._postgres is None:
            return 0.0
        with self.uncounted():
            for session in _children(self._postgres):
                if (spent := _spent(session)) is not None:
                    self._sessions[session] = spent
        return sum(self._sessions.values()) - self._database_from

    @property
    def total(self) -> float:
        """Both: the service waits while its database works."""
        return self.service + self.database

    @contextmanager
    def uncounted(self) -> Iterator[None]:
        """Do not count this thread's time in this context."""
        begun = time.thread_time()
        try:
            yield
        finally:
            self._uncounted += time.thread_time() - begun


def _children(process: int) -> list[int]:
    text = Path(f"/proc/{process}/task/{process}/children").read_text()
    return [int(word) for word in text.split()]


def _spent(process: int) -> float | None:
    """Seconds that a session has been on a processor; None for another process."""
    folder = Path(f"/proc/{process}")
    try:
        if not (folder / "cmdline").read_bytes().startswith(SESSION):
            return None
        return int((folder / "schedstat").read_text().split()[0]) / 1e9
    except OSError:  # it has just ended
        return None
