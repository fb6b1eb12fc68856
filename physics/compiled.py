"""Compiled code: the decorators for numba kernels, and where their machine code is kept.

Numba keeps compiled kernels on disk, but looks at the kernel's own file alone: it would go on using
an old kernel after a function in another file, which that kernel calls, was changed. So the cache
lies in a folder named after a hash of every source file that may hold kernels.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

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
    config.CACHE_DIR = str(_FOLDER)
    try:
        jit = numba.njit(
            cache=_CAN_KEEP,
            nogil=True,
            error_model="numpy",
            fastmath=fastmath,
            forceinline=bool(fastmath),
        )
        return cast("F", jit(function))
    finally:
        config.CACHE_DIR = others


def _cache_folder() -> Path:
    """The folder of the kernels of exactly this source code."""
    root = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for package in ("physics", "algorithms"):
        for file in sorted((root / package).rglob("*.py")):
            digest.update(f"{file.relative_to(root)}\0".encode())
            digest.update(file.read_bytes())
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(home).expanduser() / "d3pg" / f"kernels-{digest.hexdigest()[:16]}"


def _can_keep(folder: Path) -> bool:
    """Whether kernels can be written there; where they cannot, each process compiles its own."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


_FOLDER = _cache_folder()
_CAN_KEEP = _can_keep(_FOLDER)
