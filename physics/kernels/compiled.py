"""Compiled code: the decorators for numba kernels, and where their machine code is cached.

Numba caches compiled kernels on disk, but checks only the kernel's own file: it would continue to
use an old kernel after a change to a function that the kernel calls from another file. So the
kernels of a file lie in a folder named after a hash of that file and of all it imports: a change
recompiles only the kernels that it may affect, and all checkouts of the same source share them.
"""

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from physics.kernels import source_closure
from physics.kernels.cache import KernelCache
from physics.kernels.linking import Kernel

F = TypeVar("F", bound=Callable[..., Any])

# Operations may be reordered and fused; NaN and infinity keep their meaning, so that a diverging
# network is still detected.
_REORDERED = {"reassoc", "contract", "nsz", "arcp"}


def compiled(function: F) -> F:
    """Compile a physics kernel: IEEE arithmetic as written, GIL released, cached on disk."""
    return _kernel(function, fastmath=False)


def compiled_fast(function: F) -> F:
    """Compile a network kernel: as `compiled`, but sums may be reordered and fused.

    The order of a loop's operations must not depend on where its arrays lie. So no loop both sums
    and stores: whether such a loop is vectorised is decided as it runs, by the distance between its
    arrays, and a vectorised sum has other bits.
    """
    return _kernel(function, fastmath=_REORDERED)


def _kernel(function: F, fastmath: bool | set[str]) -> F:
    """Compile `function` with our cache folder, and leave numba's own setting to other packages."""
    config: Any = numba.config
    if config.DISABLE_JIT:  # for debugging in Python
        return function
    others = config.CACHE_DIR
    folder = _cache_folder(function.__code__.co_filename)
    config.CACHE_DIR = str(folder)
    try:
        kernel: Any = Kernel(
            function, {"nogil": True, "error_model": "numpy", "fastmath": fastmath}
        )
        if _can_keep(folder):
            kernel._cache = KernelCache(function)  # as `cache=True` sets numba's own
            kernel.compile = kernel._cache.one_compiles(kernel.compile)
        return cast("F", kernel)
    finally:
        config.CACHE_DIR = others


@cache
def _cache_folder(file: str) -> Path:
    """The folder of a file's kernels, for exactly this source code."""
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    name = f"{Path(file).stem}-{source_closure.digest(Path(file))}"
    return Path(home).expanduser() / "d3pg" / "kernels" / name


@cache
def _can_keep(folder: Path) -> bool:
    """Whether kernels can be written there; where they cannot, each process compiles its own."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)
