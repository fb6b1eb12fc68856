"""A folder: the files of one run, on a disk or in a bucket, and all that is asked of either.

Every method raises OSError, whose `strerror` says in words what was wrong.
"""

from collections.abc import Callable
from typing import Protocol


class UnavailableError(OSError):
    """The place where the files lie cannot be had until somebody does what `strerror` says."""


class UnreachableError(UnavailableError):
    """The place does not answer; that may pass by itself."""


class Folder(Protocol):
    """The files of one run. It is made by the first that is written."""

    def write(self, name: str, content: bytes) -> None:
        """Make or replace a file: whole or not at all, and to stay once this has returned."""

    def append(self, name: str, size: int, piece: bytes) -> None:
        """Make a file its first `size` bytes and this piece, to stay once this has returned.

        What lay beyond `size` is of a try that failed. Where this one fails, those bytes are as
        they were.
        """

    def read(self, name: str) -> bytes:
        """Read a file that was written. Raises FileNotFoundError where it is missing."""

    def read_beginning(self, name: str, size: int) -> bytes:
        """Read the first `size` bytes of a file that was appended to. Raises FileNotFoundError."""

    def names(self) -> list[str]:
        """The files there are, in no order."""

    def size(self, name: str) -> int:
        """Bytes of a file, with all that was appended to it; 0 where it is missing."""

    def remove(self, is_unneeded: Callable[[str], bool]) -> None:
        """Remove the files whose names are unneeded."""
