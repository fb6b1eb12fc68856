"""Kernel cache: numba's files of machine code, each sealed by the SHA-256 of its contents.

numba reads what lies on the disk as it is: a file cut short is an `EOFError` at every use, and one
with a flipped bit is other machine code. Here a file without its seal counts as missing: its kernel
is compiled again and the file replaced. Where nothing can be written, nothing is kept.
"""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import Any

from numba.core import caching

_caching: Any = caching  # without types
_SEAL = hashlib.sha256().digest_size


class KernelCache(_caching.FunctionCache):  # type: ignore[misc]
    """The machine code of one function."""

    def __init__(self, function: Callable[..., Any]) -> None:
        """Look where numba would, which is in its `CACHE_DIR` of this moment."""
        super().__init__(function)
        self._cache_file = _SealedFiles(
            cache_path=self.cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self._impl.locator.get_source_stamp(),
        )

    def save_overload(self, signature: Any, data: Any) -> None:
        """Keep what was compiled; a full disk, say, only means that it is compiled again."""
        with suppress(OSError):
            super().save_overload(signature, data)


class _SealedFiles(_caching.IndexDataCacheFile):  # type: ignore[misc]
    """The index of a function's signatures and the code of each: pickles, which a seal follows."""

    def _load_index(self) -> Any:
        return super()._load_index() if _is_sealed(Path(self._index_path)) else {}

    def _load_data(self, name: str) -> Any:
        if not _is_sealed(Path(self._data_path(name))):
            raise FileNotFoundError(f"{name} is damaged")  # which numba takes for a missing one
        return super()._load_data(name)

    @contextmanager
    def _open_for_write(self, path: str) -> Iterator[BytesIO]:
        contents = BytesIO()
        yield contents
        with super()._open_for_write(path) as file:
            file.write(contents.getvalue() + hashlib.sha256(contents.getvalue()).digest())


def _is_sealed(path: Path) -> bool:
    """Whether a file can be read and ends with the hash of what stands before."""
    try:
        contents = path.read_bytes()
    except OSError:
        return False
    return hashlib.sha256(contents[:-_SEAL]).digest() == contents[-_SEAL:]
