"""Compiled code: the decorators for numba kernels, and where their machine code is kept.

Numba keeps compiled kernels on disk, but looks at the kernel's own file alone: it would go on using
an old kernel after a function in another file, which that kernel calls, was changed. So the kernels
of a file lie in a folder named after a hash of that file and of all it imports: a change compiles
again what it may concern, and nothing else, and every checkout of the same source finds the same.
"""

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from physics.kernels import source_closure
from physics.kernels.cache import KernelCache

F = TypeVar("F", bound=Callable[..., Any])

# Rounding may be reordered and fused; NaN and infinity keep their meaning, so that a diverging
# network is still seen to diverge.
_REORDERED = {"reassoc", "contract", "nsz", "arcp"}


def compiled(function: F) -> F:
    """Compile a physics kernel: IEEE arithmetic as written, GIL released, kept on disk."""
    return _jit(function, fastmath=False)


def compiled_fast(function: F) -> F:
    """Compile a network kernel: as `compiled`, but sums may be reordered and fused.

    Always inlined. A callee with a body of its own is in memory twice, once for itself and once in
    its caller, each reordered in its own way; which of the two a process runs depends on whether it
    compiled the callee or found the caller in the cache. Then the bits would, too.
    """
    return _jit(function, fastmath=_REORDERED)


def _jit(function: F, fastmath: bool | set[str]) -> F:
    """Compile `function` with our cache folder, leaving numba's own setting to other packages."""
    config: Any = numba.config
    others = config.CACHE_DIR
    folder = _cache_folder(function.__code__.co_filename)
    config.CACHE_DIR = str(folder)
    try:
        kernel: Any = numba.njit(
            nogil=True, error_model="numpy", fastmath=fastmath, forceinline=bool(fastmath)
        )(function)
        if kernel is not function and _can_keep(folder):  # it is with NUMBA_DISABLE_JIT
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
