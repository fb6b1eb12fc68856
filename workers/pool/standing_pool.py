"""The pool of a separate process, such as in a container of its own.

Service and process share only a folder with the socket. Each is started and ended by itself: the
process waits for services, follows one and ends when it closes the pool; a supervisor starts the
process again.
"""

import contextlib
import socket
from pathlib import Path

from workers.driver.terms import Terms
from workers.pool.driven_pool import GREETING_SECONDS, DrivenPool
from workers.pool.pool import PoolUnavailableError

CLOSING_SECONDS = 5.0
"""How long to wait until the process has ended its workers; it goes on after that."""


class StandingPool(DrivenPool):
    """A Pool (see workers/pool/pool.py) of the process that listens at a socket."""

    def __init__(self, path: Path, terms: Terms) -> None:
        """Connect to nothing yet."""
        super().__init__()
        self._path = path
        self._terms = terms

    def start(self) -> None:
        """Connect to the process. Raises PoolUnavailableError if there is none."""
        self.close()
        try:
            is_up = self._connect(self._path, self._terms, GREETING_SECONDS)
        except OSError as error:
            raise PoolUnavailableError(
                f"no process that drives Ray answers at {self._path} ({error.strerror or error}): "
                "check that it is running"
            ) from error
        if not is_up:
            raise PoolUnavailableError(
                f"the process that drives Ray at {self._path} hung up: its log says why"
            )

    def close(self) -> None:
        """Let the process end its workers and itself."""
        if self._channel is None or self._listener is None:
            return
        self._send(do="close")
        with contextlib.suppress(OSError):
            self._channel.shutdown(socket.SHUT_WR)
        self._listener.join(CLOSING_SECONDS)
        self._channel.close()
        self._channel = self._listener = None

    def _last_words(self) -> str:
        return f"the process that drives Ray at {self._path} ended: its log says why"
