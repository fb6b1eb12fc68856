"""Removing the checkpoints of runs that have ended; what they learned stays.

Whose are to be removed stands in the database, so none is forgotten when the service dies.
"""

from service.queue.rounds import Rounds
from service.store.store import Store
from workers.checkpoints.checkpoint_folder import remove_checkpoints
from workers.checkpoints.place import Place

AT_ONCE = 256


class CheckpointRemoval(Rounds):
    """Looks every few seconds."""

    def __init__(self, store: Store, place: Place) -> None:
        """Begin nothing yet."""
        super().__init__("checkpoint removal")
        self._store = store
        self._place = place

    def work(self) -> bool:
        """Remove some."""
        return self.remove() == AT_ONCE

    def remove(self) -> int:
        """Remove what is to be removed, and return of how many runs."""
        ended = self._store.ended_with_checkpoints(AT_ONCE)
        for run_id in ended:
            remove_checkpoints(self._place, run_id)
        if ended:
            self._store.forget_checkpoints(ended)
        return len(ended)
