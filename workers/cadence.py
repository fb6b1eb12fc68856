"""Cadence: when the next checkpoint is due.

    wait = min(60 s, max(5 s, cost of the last one / 2 %))

So at most 60 s of work are lost with a worker, and checkpoints cost at most 2 % of its time (more
only where a single one takes over 1.2 s).
"""

import time
from collections.abc import Callable

LONGEST_SECONDS = 60.0
SHORTEST_SECONDS = 5.0
SHARE = 0.02


class Cadence:
    """Counts from its making, then from the end of each checkpoint."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin to count; the clock is for tests."""
        self._clock = clock
        self._due_at = clock() + SHORTEST_SECONDS

    @property
    def is_due(self) -> bool:
        """Whether it is time for the next checkpoint."""
        return self._clock() >= self._due_at

    def took(self, seconds: float) -> None:
        """Take into account what a checkpoint just written took."""
        wait = min(LONGEST_SECONDS, max(SHORTEST_SECONDS, seconds / SHARE))
        self._due_at = self._clock() + wait
