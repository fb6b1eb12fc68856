"""Removing the checkpoints of runs that have ended; what they learned stays.

Whose are to be removed stands in the database, so none is forgotten when the service dies.
"""

import threading

import structlog

from service.store.store import Store
from workers.checkpoints.checkpoint_folder import remove_checkpoints
from workers.checkpoints.place import Place

log = structlog.get_logger(__name__)

ROUND_SECONDS = 5.0
AT_ONCE = 256
STOP_SECONDS = 1.0


class CheckpointRemoval:
    """Looks every few seconds, on a thread of its own. `start` begins, `stop` ends."""

    def __init__(self, store: Store, place: Place) -> None:
        """Begin nothing yet."""
        self._store = store
        self._place = place
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="checkpoint removal", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Stop after what is under way, or leave it where its place does not answer.

        The next service removes what was not.
        """
        self._stopping.set()
        self._thread.join(STOP_SECONDS)

    def remove(self) -> int:
        """Remove what is to be removed, and return of how many runs."""
        ended = self._store.ended_with_checkpoints(AT_ONCE)
        for run_id in ended:
            remove_checkpoints(self._place, run_id)
        if ended:
            self._store.forget_checkpoints(ended)
        return len(ended)

    def _run(self) -> None:
        while not self._stopping.wait(ROUND_SECONDS):
            try:
                while self.remove() == AT_ONCE and not self._stopping.is_set():
                    pass
            except OSError as trouble:  # tried again
                reason = trouble.strerror
                log.warning("checkpoints of ended runs could not be removed", reason=reason)
            except Exception:  # the database refuses: tried again
                log.exception("checkpoints of ended runs could not be removed")
