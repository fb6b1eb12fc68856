"""Reports on their way to the service, kept until it says that they are recorded.

Reports do not depend on a listening service: reports that were not acknowledged are sent again to
the next service, after a line for each worker that says what it was doing before. While no service
listens, the lines are also written to a file (the spool). If this process ends, too, the next one
sends the lines of the spool, with the loss of each worker.
"""

import contextlib
import socket
import threading
from collections import deque
from io import BufferedWriter
from pathlib import Path

from workers.messages.report import Lost, from_line, heading, to_line

GREETING = "greeting"
"""The first line of every connection: the pool is ready."""


class Roster:
    """The lines that say what each worker is doing, and what the cluster has room for."""

    def __init__(self) -> None:
        """Know of no worker."""
        self._capacity: list[str] = []  # the last one
        self._ready: dict[str, str] = {}
        self._doing: dict[str, str] = {}

    def take(self, line: str) -> None:
        """Take a report into account."""
        kind, worker = heading(line)
        match kind:
            case "ready":
                self._ready[worker] = self._doing[worker] = line
            case "busy":
                self._doing[worker] = line
            case "ended" | "failed":
                if worker in self._ready:
                    self._doing[worker] = self._ready[worker]
            case "lost" | "retired":
                self._ready.pop(worker, None)
                self._doing.pop(worker, None)
            case "capacity":
                self._capacity = [line]

    @property
    def lines(self) -> list[str]:
        """One for the cluster, once it is known, and one for each worker."""
        return [*self._capacity, *self._doing.values()]

    @property
    def workers(self) -> list[str]:
        """Their names."""
        return list(self._doing)

    @property
    def is_busy(self) -> bool:
        """Whether any worker trains."""
        return any(heading(line).kind == "busy" for line in self._doing.values())


class Outbox:
    """Takes lines from any thread and sends them on one of its own."""

    def __init__(self, spool: Path) -> None:
        """Start the thread, with the lines that an earlier process left; no service listens yet."""
        self._spool_path = spool
        self._spool: BufferedWriter | None = None
        self._lock = threading.Condition()
        self._channel: socket.socket | None = None
        self._recorded = Roster()  # as of the last line that was acknowledged
        self._told = Roster()
        self._unacknowledged: deque[str] = deque(lines_left_in(spool))
        self._unsent: deque[str] = deque()
        self._introduction = 0  # lines of the roster that are yet to be acknowledged
        threading.Thread(target=self._send, name="outbox", daemon=True).start()

    def put(self, line: str) -> None:
        """Send a report, now or when a service listens."""
        with self._lock:
            self._told.take(line)
            self._unacknowledged.append(line)
            self._unsent.append(line)
            if self._channel is None:
                self._write(line)
            self._lock.notify()

    def attach(self, channel: socket.socket) -> None:
        """Send a service everything that is not recorded, then new reports."""
        with self._lock:
            introduction = self._recorded.lines
            self._introduction = len(introduction)
            self._unsent = deque([GREETING, *introduction, *self._unacknowledged])
            self._channel = channel
            self._lock.notify()

    def detach(self) -> None:
        """No service listens any more: from now on, everything is on disk, too."""
        with self._lock:
            self._channel = None
            self._close_spool()
            with contextlib.suppress(OSError):
                self._begin_spool()

    def acknowledge(self, count: int) -> None:
        """The first so many lines that were sent and not acknowledged are recorded."""
        with self._lock:
            of_introduction = min(count, self._introduction)
            self._introduction -= of_introduction
            for _ in range(min(count - of_introduction, len(self._unacknowledged))):
                self._recorded.take(self._unacknowledged.popleft())
            if not self._unacknowledged:
                self._close_spool()
                self._spool_path.unlink(missing_ok=True)

    @property
    def is_busy(self) -> bool:
        """Whether any worker trains."""
        with self._lock:
            return self._told.is_busy

    def _send(self) -> None:
        while True:
            with self._lock:
                self._lock.wait_for(lambda: self._channel is not None and self._unsent)
                channel, line = self._channel, self._unsent.popleft()
            if channel is not None:
                with contextlib.suppress(OSError):  # it is gone, and will be detached
                    channel.sendall(line.encode() + b"\n")

    def _write(self, line: str) -> None:
        """Append to the spool. On a full disk, the lines are only in memory."""
        with contextlib.suppress(OSError):
            if self._spool is None:
                self._begin_spool()  # with this line
            else:
                self._spool.write(line.encode() + b"\n")
                self._spool.flush()

    def _begin_spool(self) -> None:
        """Write all that is not recorded, in one step: until then, the former spool holds it."""
        self._spool_path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        draft = self._spool_path.with_suffix(".unfinished")
        spool = draft.open("wb")
        try:
            for line in (*self._recorded.lines, *self._unacknowledged):
                spool.write(line.encode() + b"\n")
            spool.flush()
            draft.replace(self._spool_path)
        except OSError:
            spool.close()
            raise
        self._spool = spool

    def _close_spool(self) -> None:
        if self._spool is not None:
            with contextlib.suppress(OSError):
                self._spool.close()
            self._spool = None


def lines_left_in(spool: Path) -> list[str]:
    """Return the reports of a process that has ended, with the loss of each of its workers.

    The last line may have been cut off: a damaged line and all that follow it are left out.
    """
    roster = Roster()
    lines: list[str] = []
    try:
        found = spool.read_bytes().split(b"\n")
    except OSError:
        return lines
    for line in found:
        try:
            from_line(line)
        except ValueError:
            break
        lines.append(line.decode())
        roster.take(lines[-1])
    reason = "its worker ended while the service was away"
    return [*lines, *(to_line(Lost(worker, reason, "")) for worker in roster.workers)]
