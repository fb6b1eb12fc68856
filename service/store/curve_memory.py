"""Curves of ended runs, kept in memory: a repeated look at a sweep reads only what is new.

An ended run has no new measurements. A retry or more timesteps let it go on, and it ends again as
another attempt or at another time; both are in the key.
"""

import threading
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from cachetools import LRUCache
from numpy.typing import NDArray

OBJECTS = 400
"""Bytes of the objects around two arrays."""


@dataclass(frozen=True)
class Line:
    """One metric of one run over one abscissa, both float64 [n] and read-only.

    shares_x  whether another line brought its places already
    """

    x: NDArray[np.float64]
    values: NDArray[np.float64]
    shares_x: bool = False

    @property
    def bytes(self) -> int:
        """Its bytes, without the arrays that it shares."""
        return (0 if self.shares_x else self.x.nbytes) + self.values.nbytes + OBJECTS


class CurveMemory:
    """The most recently used lines, within a number of bytes. Safe from any thread."""

    def __init__(self, most_bytes: int) -> None:
        """Keep nothing yet."""
        self._lines: LRUCache[Hashable, Line] = LRUCache(most_bytes, getsizeof=_size)
        self._lock = threading.Lock()

    def get(self, key: Hashable) -> Line | None:
        """Return the line of that key, if it is still kept."""
        with self._lock:
            return self._lines.get(key)

    def keep(self, key: Hashable, line: Line) -> None:
        """Keep the line until newer ones replace it; a line larger than the memory is not kept."""
        if line.bytes <= self._lines.maxsize:
            with self._lock:
                self._lines[key] = line


def _size(line: Line) -> int:
    return line.bytes
