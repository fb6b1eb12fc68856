"""A folder: the files of one run, on a disk or in a bucket, and the operations on both.

Every method raises OSError, whose `strerror` says in words what was wrong.
"""

from collections.abc import Callable
from typing import Protocol


class UnavailableError(OSError):
    """The place of the files is unavailable until somebody does what `strerror` says."""


class UnreachableError(UnavailableError):
    """The place does not answer; that may pass by itself."""


class Folder(Protocol):
    """The files of one run. The first file that is written makes the folder."""

    def write(self, name: str, content: bytes) -> None:
        """Make or replace a file, completely or not at all; it is durable once this returns."""

    def append(self, name: str, size: int, piece: bytes) -> None:
        """Make a file its first `size` bytes and this piece; it is durable once this returns.

        Bytes beyond `size` are from a failed try. If this try fails, the first bytes are as they
        were.
        """

    def read(self, name: str) -> bytes:
        """Read a file that was written. Raises FileNotFoundError where it is missing."""

    def read_beginning(self, name: str, size: int) -> bytes:
        """Read the first `size` bytes of a file that was appended to. Raises FileNotFoundError."""

    def names(self) -> list[str]:
        """The names of the files, in no order."""

    def size(self, name: str) -> int:
        """Bytes of a file, with all that was appended to it; 0 where it is missing."""

    def remove(self, is_unneeded: Callable[[str], bool]) -> None:
        """Remove the files whose names are unneeded."""
