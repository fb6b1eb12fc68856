"""Admission of services, one after the other: all of them have the same terms."""

import math
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from io import BufferedReader
from typing import NamedTuple

from workers.driver.outbox import Outbox
from workers.driver.settings import DriverSettings
from workers.driver.terms import Terms, UnusableTermsError

NO_SERVICE_SECONDS = 900.0
"""How long workers train on without a service; after that, their checkpoints remain."""
IDLE_NO_SERVICE_SECONDS = 30.0
FIRST_WORD_SECONDS = 5.0
LONGEST_TERMS = 65536


class Visit(NamedTuple):
    """A service that is connected, and what it says after its terms."""

    channel: socket.socket
    lines: BufferedReader


class OtherTermsError(Exception):
    """A service has other terms than the one before it."""


class Reception:
    """Admits services: the first sets the terms, and one with other terms ends the process."""

    def __init__(self, listener: socket.socket, outbox: Outbox, *, waits_long: bool) -> None:
        """Wait for no service yet; `waits_long`: wait for the first one without a limit."""
        listener.settimeout(1.0)
        self._listener = listener
        self._outbox = outbox
        self._patience_at_first = math.inf if waits_long else IDLE_NO_SERVICE_SECONDS
        self._terms: Terms | None = None
        self._first: Visit | None = None

    def first_terms(self) -> Terms | None:
        """Wait for a service and return its terms; None if none connects."""
        self._first = self._next(self._patience_at_first)
        return self._terms

    def visits(self) -> Iterator[Visit]:
        """Yield one service after the other, until none connects for long or one has other terms.

        Each receives all reports until the next service is requested.
        """
        visit = self._first
        while visit is not None:
            with visit.channel, visit.lines:
                yield visit
                self._outbox.detach()
            visit = self._next(self._patience)

    @property
    def _patience(self) -> float:
        return NO_SERVICE_SECONDS if self._outbox.is_busy else IDLE_NO_SERVICE_SECONDS

    def _next(self, patience: float) -> Visit | None:
        """Wait so long for a service that can be admitted."""
        deadline = time.monotonic() + patience
        while time.monotonic() < deadline:
            try:
                channel, _ = self._listener.accept()
                return self._admitted(channel)
            except UnusableTermsError as error:
                print(f"A service was refused: {error}.", file=sys.stderr, flush=True)  # noqa: T201
            except OtherTermsError:
                return None
            except OSError:  # nobody came in this second, or went at once
                continue
        return None

    def _admitted(self, channel: socket.socket) -> Visit:
        """Hear the terms of a service and greet it, or hang up.

        Raises UnusableTermsError, OtherTermsError, and OSError where it says nothing.
        """
        with ExitStack() as unless_admitted:
            unless_admitted.enter_context(channel)
            channel.settimeout(FIRST_WORD_SECONDS)
            lines = unless_admitted.enter_context(channel.makefile("rb"))
            terms = Terms.from_line(lines.readline(LONGEST_TERMS))
            if terms != (self._terms or terms):
                raise OtherTermsError
            channel.settimeout(None)
            unless_admitted.pop_all()
        self._terms = terms
        self._outbox.attach(channel)
        return Visit(channel, lines)


@contextmanager
def listening(settings: DriverSettings) -> Iterator[socket.socket]:
    """Listen at the socket that the settings name: for this user alone, where it is made here."""
    if not settings.stands_alone:
        with socket.socket(fileno=settings.listener) as listener:
            yield listener
        return
    path = settings.socket
    path.unlink(missing_ok=True)  # of a process that is no more
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
        path.chmod(0o600)
        listener.listen(1)
        yield listener
