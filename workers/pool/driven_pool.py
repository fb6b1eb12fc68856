"""A pool that a process drives, as its service sees it: a socket with commands and reports.

Commands go one way and reports the other, as lines. Holders of Ray's token may run code beside that
process, so its lines are only read as reports and not trusted otherwise.
"""

import json
import queue
import socket
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Collection
from contextlib import ExitStack
from io import BufferedReader
from pathlib import Path
from typing import Any

from workers.driver.terms import Terms
from workers.messages.report import Report, from_line
from workers.messages.work import Work
from workers.pool.pool import PoolUnavailableError

GREETING_SECONDS = 5.0
"""How long an earlier process may take to answer before it is not reused."""
LONGEST_LINE = 2**24


class DrivenPool(ABC):
    """A Pool (see workers/pool/pool.py), without the start and end of its process."""

    def __init__(self) -> None:
        """Connect to nothing yet."""
        self._reports: queue.SimpleQueue[Report | None] = queue.SimpleQueue()
        self._channel: socket.socket | None = None
        self._listener: threading.Thread | None = None

    @abstractmethod
    def start(self) -> None:
        """Get a process that drives the pool. Raises PoolUnavailableError."""

    @abstractmethod
    def close(self) -> None:
        """End all workers."""

    @abstractmethod
    def _last_words(self) -> str:
        """Why the process does not drive the pool any more, a sentence."""

    def train(self, worker: str, work: Work) -> None:
        """Train a cohort."""
        self._send(do="train", worker=worker, work=work.to_json())

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        """Stop training these seeds."""
        self._send(do="drop", worker=worker, seeds=sorted(seeds))

    def kill(self, worker: str) -> None:
        """End a worker's process."""
        self._send(do="kill", worker=worker)

    def demand(self, workers: int) -> None:
        """Tell for how many workers there is work."""
        self._send(do="demand", workers=workers)

    def acknowledge(self, count: int) -> None:
        """Mark the next `count` reports, in their order, as recorded."""
        self._send(do="acknowledge", count=count)

    def reports(self, timeout_seconds: float, gather_seconds: float = 0.0) -> list[Report]:
        """Wait for reports. Raises PoolUnavailableError when the process has ended.

        Its own processes are ended then, too.
        """
        found: list[Report] = []
        try:
            report = self._reports.get(timeout=timeout_seconds)
            until = time.monotonic() + gather_seconds
            while report is not None:
                found.append(report)
                report = self._reports.get(timeout=max(until - time.monotonic(), 0.0))
        except queue.Empty:
            return found
        if found:
            self._reports.put(None)  # the end is told next time, after what came before it
            return found
        last_words = self._last_words()
        self.close()
        raise PoolUnavailableError(last_words)

    def _connect(self, path: Path, terms: Terms, greeting_seconds: float | None) -> bool:
        """Connect to a process and request workers; return whether it agrees in that time.

        None: a process of ours, which will. Raises OSError if no process listens.
        """
        with ExitStack() as unless_connected:
            channel = unless_connected.enter_context(socket.socket(socket.AF_UNIX))
            lines = unless_connected.enter_context(channel.makefile("rb"))
            channel.connect(str(path))
            channel.sendall(terms.to_line())
            if greeting_seconds is not None:
                channel.settimeout(greeting_seconds)
                if not lines.peek(1):
                    return False
                channel.settimeout(None)
            unless_connected.pop_all()
        self._channel = channel
        self._reports = queue.SimpleQueue()
        self._listener = threading.Thread(
            target=_listen, args=(lines, self._reports), name="pool reports", daemon=True
        )
        self._listener.start()
        return True

    def _send(self, **command: Any) -> None:
        if self._channel is None:
            raise PoolUnavailableError("the pool has not been started")
        try:
            self._channel.sendall(json.dumps(command).encode() + b"\n")
        except OSError:
            return  # its end is told by `reports`


def _listen(lines: BufferedReader, reports: "queue.SimpleQueue[Report | None]") -> None:
    """Turn lines into reports, after the greeting, until the stream ends or a line is none."""
    try:
        with lines:
            lines.readline(LONGEST_LINE)
            while line := lines.readline(LONGEST_LINE):
                reports.put(from_line(line))
    except (OSError, ValueError, RecursionError):  # cut off, perhaps within a line
        pass
    reports.put(None)
