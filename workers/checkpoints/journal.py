"""Journal: the experience of a run, in one file an attempt that only grows.

    per piece: its length (8 bytes, little-endian), its arrays (`sealed_file.packed`)

A reference to it has the number of bytes that it means, and their SHA-256. So a piece that was cut
short, or that has no reference, does no harm, and a successor can read a file to which a worker
still appends.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

from algorithms.state import State
from workers.checkpoints.folder import Folder
from workers.checkpoints.sealed_file import DamagedError, packed, read_damage, unpacked

LENGTH_SIZE = 8


@dataclass(frozen=True)
class Beginning:
    """The first bytes of a journal's file: how many, and their digest."""

    file: str
    size: int
    digest: str


class Journal:
    """The journal of one attempt, which has no other writer."""

    def __init__(self, folder: Folder, name: str) -> None:
        """Write nothing yet."""
        self._folder = folder
        self._name = name
        self._size = 0
        self._hash = hashlib.sha256()

    def append(self, arrays: State) -> None:
        """Append a piece. Raises OSError, with the journal unchanged."""
        payload = packed(arrays)
        piece = len(payload).to_bytes(LENGTH_SIZE, "little") + payload
        self._folder.append(self._name, self._size, piece)
        self._size += len(piece)
        self._hash.update(piece)

    def so_far(self) -> list[Beginning]:
        """A reference to all of it; nothing while it is empty."""
        whole = Beginning(self._name, self._size, self._hash.hexdigest())
        return [whole] if self._size else []


def pieces(folder: Folder, beginning: Beginning) -> Iterator[State]:
    """The pieces that were appended, in their order. Raises DamagedError, UnavailableError."""
    with read_damage(beginning.file):
        content = folder.read_beginning(beginning.file, beginning.size)
    if hashlib.sha256(content).hexdigest() != beginning.digest:
        raise DamagedError(f"hash mismatch of {beginning.file}")
    start = 0
    while start < len(content):
        stop = start + LENGTH_SIZE
        length = int.from_bytes(content[start:stop], "little")
        yield unpacked(content[stop : stop + length])
        start = stop + length
