"""A process beside the service for what would hold it up: drawing figures, playing episodes.

It is started when first needed, runs one call after the other at a lower priority, and ends with
the service, whose end closes its pipe. A call that takes too long is ended with the process; the
next call starts another process. A call that has waited too long, or whose client has gone when its
turn comes, is not begun.
Functions go by name ("module:function"), so that the service itself loads neither
matplotlib nor numba nor torch. The pipe carries pickles between our own two ends only. The process
runs the code of tasks: it has no secret of the service in its environment.
"""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pkgutil import resolve_name
from typing import Any, Protocol

from workers.pool.environment import without_ray_token, without_secrets

MOST_WAITING = 16
WAITING_SECONDS = 30.0
"""Time to wait for a turn; browsers and proxies give up after about a minute."""
LIMIT_SECONDS = 60.0
CLOSE_SECONDS = 0.1


class BusyError(RuntimeError):
    """Too many calls wait: try again later."""


class AbandonedError(BusyError):
    """The client had gone when the turn came."""


class TooSlowError(RuntimeError):
    """The call took longer than the limit and was ended."""


def always() -> bool:
    """Return that the call is always wanted."""
    return True


class Side(Protocol):
    """Where work is done that must not hold the service up."""

    def call(self, function: str, *arguments: Any) -> Any:
        """Return what the function returns, raise what it raises; or BusyError, TooSlowError."""


class OwnSide(Side, Protocol):
    """A side that its user ends."""

    def close(self) -> None:
        """End what was started."""


class SideProcess:
    """One process, started at the first call. Safe from any thread."""

    def __init__(
        self, limit_seconds: float = LIMIT_SECONDS, waiting_seconds: float = WAITING_SECONDS
    ) -> None:
        """Start nothing yet."""
        self._limit_seconds = limit_seconds
        self._waiting_seconds = waiting_seconds
        self._waiting = threading.Semaphore(MOST_WAITING)
        self._turn = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._pipe: Connection | None = None
        self._is_closed = False

    def call(self, function: str, *arguments: Any, is_wanted: Callable[[], bool] = always) -> Any:
        """Run a function in the process, after the calls that came before.

        Raises what the function raises; BusyError if too many calls wait, if the turn does not come
        in time, or if the call is not wanted any more when it comes; TooSlowError; EOFError if the
        process died of it.
        """
        if not self._waiting.acquire(blocking=False):
            raise BusyError(f"{MOST_WAITING} others wait already")
        try:
            if not self._turn.acquire(timeout=self._waiting_seconds):
                raise BusyError(f"others before it took {self._waiting_seconds:g} s")
            try:
                if not is_wanted():
                    raise AbandonedError("nobody waits for it any more")
                return self._call(function, arguments)
            finally:
                self._turn.release()
        finally:
            self._waiting.release()

    def close(self) -> None:
        """End the process at once: the call that is under way raises EOFError."""
        self._is_closed = True
        while not self._turn.acquire(timeout=CLOSE_SECONDS):
            if self._process is not None:
                self._process.kill()
        try:
            self._end()
        finally:
            self._turn.release()

    def _call(self, function: str, arguments: tuple[Any, ...]) -> Any:
        pipe = self._connected()
        try:
            pipe.send((function, arguments))
            if not pipe.poll(self._limit_seconds):
                raise TooSlowError(f"it took longer than {self._limit_seconds:g} s")
            result, error = pipe.recv()
        except (OSError, EOFError, TooSlowError):
            self._end()
            raise
        if error is not None:
            raise error
        return result

    def _connected(self) -> Connection:
        if self._is_closed:
            raise RuntimeError("the service is stopping")
        if self._pipe is None or self._process is None or self._process.poll() is not None:
            self._end()
            self._pipe, theirs = Pipe()
            with theirs:
                self._process = started(theirs)
        return self._pipe

    def _end(self) -> None:
        if self._pipe is not None:
            self._pipe.close()
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        self._pipe = self._process = None


def started(pipe: Connection) -> "subprocess.Popen[bytes]":
    """Start the process at the other end, which finds modules where this one does."""
    environment = without_ray_token(without_secrets(os.environ))
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    return subprocess.Popen(  # noqa: S603  (our own interpreter and module)
        [sys.executable, "-m", __name__, str(pipe.fileno())],
        pass_fds=[pipe.fileno()],
        stdin=subprocess.DEVNULL,
        env=environment,
    )


def serve(pipe: Connection) -> None:
    """Run what comes through the pipe until its other end closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the service, which ends us
    os.nice(5)
    while True:
        try:
            function, arguments = pipe.recv()
        except EOFError:
            return
        try:
            answer: tuple[Any, Exception | None] = resolve_name(function)(*arguments), None
        except Exception as error:
            answer = None, error
        pipe.send(answer)


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
