"""A folder on a disk or a shared mount.

A file is written under another name, flushed to the disk, and then renamed, so that its name never
refers to half of it, even after a power cut.
"""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path


class DiskFolder:
    """A Folder (see workers/checkpoints/folder.py), for its user alone."""

    def __init__(self, path: Path) -> None:
        """Make nothing yet."""
        self._path = path

    def write(self, name: str, content: bytes) -> None:
        """Make or replace a file. Leaves nothing behind if that fails."""
        self._make()
        unfinished = self._path / f"{name}.unfinished"
        try:
            with unfinished.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            unfinished.replace(self._path / name)
        except OSError:
            unfinished.unlink(missing_ok=True)
            raise
        self._bring_names_to_disk()

    def append(self, name: str, size: int, piece: bytes) -> None:
        """Write a piece; the name of a new file stays with the next `write`."""
        self._make()
        descriptor = os.open(self._path / name, os.O_CREAT | os.O_WRONLY, 0o600)
        with open(descriptor, "wb") as file:
            file.truncate(size)
            file.seek(size)
            file.write(piece)
            file.flush()
            os.fsync(descriptor)

    def read(self, name: str) -> bytes:
        """Read a file."""
        return (self._path / name).read_bytes()

    def read_beginning(self, name: str, size: int) -> bytes:
        """Read the first `size` bytes of a file."""
        with (self._path / name).open("rb") as file:
            return file.read(size)

    def names(self) -> list[str]:
        """The files there are, unfinished ones too."""
        try:
            return os.listdir(self._path)
        except FileNotFoundError:
            return []

    def size(self, name: str) -> int:
        """Bytes of a file."""
        try:
            return (self._path / name).stat().st_size
        except FileNotFoundError:
            return 0

    def remove(self, is_unneeded: Callable[[str], bool]) -> None:
        """Remove files, and the folder where none is left."""
        for name in filter(is_unneeded, self.names()):
            (self._path / name).unlink(missing_ok=True)
        with suppress(OSError):
            self._path.rmdir()

    def _make(self) -> None:
        self._path.mkdir(mode=0o700, parents=True, exist_ok=True)

    def _bring_names_to_disk(self) -> None:
        """Make sure that the names in the folder survive a power cut."""
        descriptor = os.open(self._path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
