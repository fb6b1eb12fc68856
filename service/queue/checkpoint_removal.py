"""Removing the checkpoints of runs that have ended; what they learned stays.

Runs that reached their end keep their last one while there is room, so that they can go on to more
timesteps: the oldest are removed first. The database has the runs whose checkpoints are to be
removed, so none is forgotten when the service dies.
"""

from collections.abc import Sequence

from service.queue.rounds import Rounds
from service.store.store import Store
from workers.checkpoints.checkpoint_folder import remove_checkpoints, size_of_checkpoints
from workers.checkpoints.place import Place

AT_ONCE = 256


class CheckpointRemoval(Rounds):
    """Works every few seconds. Runs that reached their end keep a number of bytes together."""

    def __init__(self, store: Store, place: Place, keep_bytes: int = 0) -> None:
        """Begin nothing yet."""
        super().__init__("checkpoint removal")
        self._store = store
        self._place = place
        self._keep_bytes = keep_bytes

    def work(self) -> bool:
        """Remove some."""
        return self.remove() == AT_ONCE

    def remove(self) -> int:
        """Remove checkpoints, and return of how many runs."""
        ended = self._store.ended_with_checkpoints(AT_ONCE)
        kept = [run_id for run_id, is_whole in ended.items() if is_whole and self._keep_bytes]
        if kept:
            sizes = {run_id: size_of_checkpoints(self._place, run_id) for run_id in kept}
            self._store.keep_last(sizes)
        self._remove([run_id for run_id in ended if run_id not in kept])
        beyond = self._store.checkpoints_beyond(self._keep_bytes, AT_ONCE)
        self._remove(beyond)
        return max(len(ended), len(beyond))

    def _remove(self, run_ids: Sequence[str]) -> None:
        for run_id in run_ids:
            remove_checkpoints(self._place, run_id)
        if run_ids:
            self._store.forget_checkpoints(run_ids)
