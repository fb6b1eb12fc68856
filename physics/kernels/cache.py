"""Kernel cache: numba's files of machine code, each sealed by the SHA-256 of its contents.

numba does not check the files that it reads: a truncated file is an `EOFError` at every use, and a
flipped bit changes the machine code. Here a file without its seal counts as missing: its kernel is
compiled again and the file replaced. Where nothing can be written, nothing is cached.

If several processes need a kernel at the same time, one compiles it and the others wait for its
file. The lock is the operating system's: it is released when the process that holds it ends.
"""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import wraps
from io import BytesIO
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout
from numba.core import caching, event
from numba.core.compiler_lock import global_compiler_lock

_caching: Any = caching  # without types
_events: Any = event
_compiler_lock: Any = global_compiler_lock
_SEAL = hashlib.sha256().digest_size

WAITING = "d3pg:waiting_for_kernel"
"""The numba event of waiting for a kernel that another process compiles."""
PATIENCE_SECONDS = 600.0
"""After this time a kernel is compiled here too: the other process may be suspended."""


class _Folder(_caching.UserProvidedCacheLocator):  # type: ignore[misc]
    """numba's `CACHE_DIR`, without a subfolder for the path of the source."""

    @classmethod
    def get_suitable_cache_subpath(cls, py_file: str) -> str:
        """Return "", no subfolder: the name of `CACHE_DIR` already identifies the source."""
        del py_file
        return ""


class _MachineCode(_caching.CompileResultCacheImpl):  # type: ignore[misc]
    """numba's compiled results, cached in this folder."""

    _locator_classes = (_Folder,)


class KernelCache(_caching.FunctionCache):  # type: ignore[misc]
    """The machine code of one function."""

    _impl_class = _MachineCode

    def __init__(self, function: Callable[..., Any]) -> None:
        """Use the present value of numba's `CACHE_DIR`."""
        super().__init__(function)
        self._cache_file = _SealedFiles(
            cache_path=self.cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self._impl.locator.get_source_stamp(),
        )
        self._lock_path = Path(self.cache_path, f"{self._impl.filename_base}.lock")
        self._until_saved = ExitStack()

    def one_compiles(self, compile_kernel: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """The dispatcher's `compile`, in which `load_overload` makes other processes wait."""

        @wraps(compile_kernel)
        def compile_or_wait(signature: Any) -> Any:
            with _compiler_lock, ExitStack() as self._until_saved:
                return compile_kernel(signature)

        return compile_or_wait

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the cached code; None if it must be compiled, while other processes wait."""
        kept = super().load_overload(signature, target)
        if kept is None:
            self._until_saved.enter_context(_locked(self._lock_path))
            kept = super().load_overload(signature, target)
        return kept

    def save_overload(self, signature: Any, data: Any) -> None:
        """Cache the compiled code; on an error, such as a full disk, it will be compiled again."""
        with suppress(OSError):
            super().save_overload(signature, data)


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold the lock; continue without it if it cannot be made or is held for too long."""
    lock = FileLock(path)
    with ExitStack() as held:
        with suppress(OSError):  # a Timeout is one too
            try:
                held.enter_context(lock.acquire(blocking=False))
            except Timeout:
                with _events.trigger_event(WAITING):
                    held.enter_context(lock.acquire(timeout=PATIENCE_SECONDS))
        yield


class _SealedFiles(_caching.IndexDataCacheFile):  # type: ignore[misc]
    """The index of a function's signatures and the code of each: pickles, each with a seal."""

    def _load_index(self) -> Any:
        return super()._load_index() if _is_sealed(Path(self._index_path)) else {}

    def _load_data(self, name: str) -> Any:
        if not _is_sealed(Path(self._data_path(name))):
            raise FileNotFoundError(f"{name} is damaged")  # numba treats it as missing
        return super()._load_data(name)

    @contextmanager
    def _open_for_write(self, path: str) -> Iterator[BytesIO]:
        contents = BytesIO()
        yield contents
        with super()._open_for_write(path) as file:
            file.write(contents.getvalue() + hashlib.sha256(contents.getvalue()).digest())


def _is_sealed(path: Path) -> bool:
    """Whether a file can be read and ends with the hash of the contents before it."""
    try:
        contents = path.read_bytes()
    except OSError:
        return False
    return hashlib.sha256(contents[:-_SEAL]).digest() == contents[-_SEAL:]
