"""A damaged file of the kernel cache is compiled again and replaced, whatever the damage."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest

from physics.kernels.cache import KernelCache

MODULE = """
from numba.core import event
from physics.kernels.compiled import compiled, compiled_fast

@compiled
def inner(x: float) -> float:
    return x + 1.0

@compiled_fast
def outer(x: float) -> float:
    return inner(x) * 2.0

if __name__ == "__main__":
    with event.install_recorder("numba:compile") as compiled_now:
        result = outer(3.0)
    print(result, len(compiled_now.buffer))
"""


def half(x: float) -> float:
    return x / 2.0


def flip(contents: bytes) -> bytes:
    middle = len(contents) * 2 // 3
    return contents[:middle] + bytes([contents[middle] ^ 1]) + contents[middle + 1 :]


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda contents: b"",
    "cut": lambda contents: contents[: len(contents) // 2],
    "flipped": flip,
    "longer": lambda contents: contents + b"\0",
}


class Program:
    """A module with two kernels, run by a new process each time."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "kernels.py"
        self.cache = folder / "cache"
        self.file.write_text(MODULE)

    def run(self) -> tuple[str, bool]:
        """What it prints, and whether it compiled anything."""
        answer = subprocess.run(
            [sys.executable, str(self.file)],
            capture_output=True,
            text=True,
            check=False,
            env={
                **os.environ,
                "XDG_CACHE_HOME": str(self.cache),
                "PYTHONPATH": str(Path(__file__).parents[3]),
            },
        )
        assert answer.returncode == 0, answer.stderr
        result, events = answer.stdout.split()
        return result, int(events) > 0

    def files(self, ending: str) -> list[Path]:
        return sorted(self.cache.rglob(f"*{ending}"))


@pytest.fixture
def program(tmp_path: Path) -> Program:
    program = Program(tmp_path)
    assert program.run() == ("8.0", True)
    assert program.run() == ("8.0", False)
    return program


def test_damaged_files_are_replaced(program: Program) -> None:
    for ending in (".nbi", ".nbc"):
        for damage in DAMAGES.values():
            assert len(program.files(ending)) == 1
            for path in program.files(ending):
                path.write_bytes(damage(path.read_bytes()))
            assert program.run() == ("8.0", True)
    assert program.run() == ("8.0", False)


def test_a_missing_file_is_compiled_again(program: Program) -> None:
    for path in program.files(".nbc"):
        path.unlink()
    assert program.run() == ("8.0", True)
    assert program.run() == ("8.0", False)


def test_what_cannot_be_kept_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    kernel: Any = numba.njit(half)
    kernel._cache = KernelCache(half)
    assert kernel(3.0) == 1.5
