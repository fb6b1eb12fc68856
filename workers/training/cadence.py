"""Cadence: when the next checkpoint is due.

    at once where  since the last one >= 60 s
    else where     since the last one >= 5 s  and  cost so far + highest of one <= 2 % of the time

So checkpoints cost at most 2 % of a worker's time, counted from when it began. Where a single one
takes over 1.2 s, both limits cannot hold, and the first wins: the limit on lost work is a promise
to users, and the share is a cost that only slow disks raise.
"""

import time
from collections.abc import Callable

LONGEST_SECONDS = 60.0
SHORTEST_SECONDS = 5.0
SHARE = 0.02


class Cadence:
    """Counts from its construction, then from the end of each checkpoint."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin to count; the clock is for tests."""
        self._clock = clock
        self._begun_at = self._last_at = clock()
        self._spent = 0.0
        self._highest = 0.0

    @property
    def is_due(self) -> bool:
        """Whether it is time for the next checkpoint."""
        now = self._clock()
        if now - self._last_at >= LONGEST_SECONDS:
            return True
        is_cheap = self._spent + self._highest <= SHARE * (now - self._begun_at)
        return is_cheap and now - self._last_at >= SHORTEST_SECONDS

    def took(self, seconds: float) -> None:
        """Take into account the time of a checkpoint that was just written."""
        self._spent += seconds
        self._highest = max(self._highest, seconds)
        self._last_at = self._clock()
