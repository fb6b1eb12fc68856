"""A process beside the service for what would hold it up: drawing figures, playing episodes.

It is started when first needed, does one thing after the other at a lower priority, and ends with
the service, however that ends: its pipe closes then. What takes too long is ended with it, and the
next call starts another. Functions go by name ("module:function"), so that the service itself loads
neither matplotlib nor numba nor torch. The pipe carries pickles between our own two ends only.
"""

import os
import signal
import threading
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pkgutil import resolve_name
from typing import Any, Protocol

MOST_WAITING = 16
LIMIT_SECONDS = 60.0
CLOSE_SECONDS = 0.1


class BusyError(RuntimeError):
    """More is waiting than is sensible: ask again later."""


class TooSlowError(RuntimeError):
    """It took longer than the limit and was ended."""


class Side(Protocol):
    """Where work is done that must not hold the service up."""

    def call(self, function: str, *arguments: Any) -> Any:
        """Return what the function returns, raise what it raises; or BusyError, TooSlowError."""

    def close(self) -> None:
        """End what was started."""


class SideProcess:
    """One process, started at the first call. Safe from any thread."""

    def __init__(self, limit_seconds: float = LIMIT_SECONDS) -> None:
        """Start nothing yet."""
        self._limit_seconds = limit_seconds
        self._waiting = threading.Semaphore(MOST_WAITING)
        self._turn = threading.Lock()
        self._process: BaseProcess | None = None
        self._pipe: Connection | None = None
        self._is_closed = False

    def call(self, function: str, *arguments: Any) -> Any:
        """Run a function over there, after those that came before.

        Raises what the function raises; BusyError where too many wait; TooSlowError; EOFError
        where the process died of it.
        """
        if not self._waiting.acquire(blocking=False):
            raise BusyError(f"{MOST_WAITING} others wait already")
        try:
            with self._turn:
                return self._call(function, arguments)
        finally:
            self._waiting.release()

    def close(self) -> None:
        """End the process at once: whoever waits for what it is doing gets an EOFError."""
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
        if self._pipe is None or self._process is None or not self._process.is_alive():
            self._end()
            context = get_context("spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()
        return self._pipe

    def _end(self) -> None:
        if self._pipe is not None:
            self._pipe.close()
        if self._process is not None:
            self._process.kill()
            self._process.join()
        self._pipe = self._process = None


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
