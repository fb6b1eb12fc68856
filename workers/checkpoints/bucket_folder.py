"""A folder in a bucket, where nothing can be appended or renamed, but an object is put whole.

    <run id>/<name>                 a file that was written
             <name>/<start>-<stop>  a piece that was appended to a file: which of its bytes

So a journal has one object for each piece. Of two tries at one place, the later one has more to
write and so another stop: no key ever has two contents, and the valid pieces are found backwards
from the requested end.
"""

import errno
import re
from collections.abc import Callable

from workers.checkpoints.bucket import Bucket

PIECE = re.compile(r".*/(?P<start>\d+)-(?P<stop>\d+)")


class BucketFolder:
    """A Folder (see workers/checkpoints/folder.py)."""

    def __init__(self, bucket: Bucket, name: str) -> None:
        """Request nothing yet."""
        self._bucket = bucket
        self._name = name

    def write(self, name: str, content: bytes) -> None:
        """Put a file."""
        self._bucket.put(f"{self._name}/{name}", content)

    def append(self, name: str, size: int, piece: bytes) -> None:
        """Put a piece; `size` is where one before it stops."""
        self._bucket.put(f"{self._name}/{name}/{size}-{size + len(piece)}", piece)

    def read(self, name: str) -> bytes:
        """Get a file."""
        [content] = self._bucket.get([f"{self._name}/{name}"])
        return content

    def read_beginning(self, name: str, size: int) -> bytes:
        """Get the pieces that make up the first `size` bytes, where one stops."""
        found = map(PIECE.fullmatch, self._bucket.keys(f"{self._name}/{name}/"))
        by_stop = {int(piece["stop"]): piece for piece in found if piece}
        keys: list[str] = []
        stop = size
        while stop:
            if stop not in by_stop:
                raise FileNotFoundError(errno.ENOENT, f"no piece of {name} stops at byte {stop}")
            keys.append(by_stop[stop][0])
            stop = int(by_stop[stop]["start"])
        return b"".join(self._bucket.get(keys[::-1]))

    def names(self) -> list[str]:
        """The files, each once, whatever the number of its pieces."""
        return list(dict.fromkeys(map(self._file_of, self._bucket.keys(f"{self._name}/"))))

    def size(self, name: str) -> int:
        """Bytes of a file with all its pieces."""
        sizes = self._bucket.sizes(f"{self._name}/{name}")
        return sum(size for key, size in sizes.items() if self._file_of(key) == name)

    def remove(self, is_unneeded: Callable[[str], bool]) -> None:
        """Remove files with all their pieces."""
        keys = self._bucket.keys(f"{self._name}/")
        self._bucket.delete([key for key in keys if is_unneeded(self._file_of(key))])

    def _file_of(self, key: str) -> str:
        return key.removeprefix(f"{self._name}/").partition("/")[0]
