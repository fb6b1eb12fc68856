"""The kernel cache: damage is made good, and of several processes one compiles."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba
import pytest
from filelock import FileLock

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

TELLING = """
import sys
from numba.core import event
from kernels import outer
from physics.kernels import cache

class Telling(event.Listener):
    def on_start(self, event):
        print(event.kind, flush=True)
        sys.stdin.readline()

    def on_end(self, event):
        pass

cache.PATIENCE_SECONDS = float(sys.argv[1])
for kind in ("numba:compile", cache.WAITING):
    event.register(kind, Telling())
print(outer(3.0), flush=True)
"""


def half(x: float) -> float:
    return x / 2.0


def flip(contents: bytes) -> bytes:
    middle = len(contents) * 2 // 3
    return contents[:middle] + bytes([contents[middle] ^ 1]) + contents[middle + 1 :]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the kernels of this process are kept."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def kernel_of_half() -> Any:
    """What the decorators make, but kept in `folder`."""
    kernel: Any = numba.njit(half)
    kernel._cache = KernelCache(half)
    kernel.compile = kernel._cache.one_compiles(kernel.compile)
    return kernel


def kept_half(x: float) -> tuple[float, str]:
    """What a new process would give, and where it would have it from."""
    kernel = kernel_of_half()
    return kernel(x), "loaded" if kernel.stats.cache_hits else "compiled"


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
        self.telling = folder / "telling.py"
        self.telling.write_text(TELLING)

    @property
    def environment(self) -> dict[str, str]:
        root = str(Path(__file__).parents[3])
        return {**os.environ, "XDG_CACHE_HOME": str(self.cache), "PYTHONPATH": root}

    def run(self) -> tuple[str, bool]:
        """What it prints, and whether it compiled anything."""
        answer = subprocess.run(
            [sys.executable, str(self.file)],
            capture_output=True,
            text=True,
            check=False,
            env=self.environment,
        )
        assert answer.returncode == 0, answer.stderr
        result, events = answer.stdout.split()
        return result, int(events) > 0

    def start(self, patience_seconds: float = 600.0) -> "Telling":
        """A process that says when it compiles or waits, and then goes on only when told to."""
        return Telling(
            [sys.executable, str(self.telling), str(patience_seconds)],
            env=self.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def files(self, ending: str) -> list[Path]:
        return sorted(self.cache.rglob(f"*{ending}"))


class Telling(subprocess.Popen[str]):
    """A process that says what it does."""

    def says(self) -> str:
        """The next line it says."""
        assert self.stdout
        return self.stdout.readline().strip()

    def go_on(self) -> None:
        """Let it go on with what it has said."""
        assert self.stdin
        self.stdin.write("\n")
        self.stdin.flush()


@pytest.fixture
def new_program(tmp_path: Path) -> Program:
    """Nothing is compiled yet."""
    return Program(tmp_path)


@pytest.fixture
def first(new_program: Program) -> Iterator[Telling]:
    """A process that compiles."""
    with new_program.start() as process:
        assert process.says() == "numba:compile"
        yield process
        process.kill()


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Program:
    """All is compiled, and each test leaves it so."""
    program = Program(tmp_path_factory.mktemp("program"))
    assert program.run() == ("8.0", True)
    assert program.run() == ("8.0", False)
    return program


def test_damaged_files_are_replaced(program: Program) -> None:
    for ending in (".nbi", ".nbc"):
        assert len(program.files(ending)) == 1
        for path in program.files(ending):
            path.write_bytes(flip(path.read_bytes()))
    assert program.run() == ("8.0", True)
    assert program.run() == ("8.0", False)


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_each_damage_to_each_file_is_seen(folder: Path, ending: str, damage: str) -> None:
    assert kept_half(3.0) == (1.5, "compiled")
    (path,) = folder.glob(f"*.{ending}")
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    assert kept_half(3.0) == (1.5, "compiled")
    assert kept_half(3.0) == (1.5, "loaded")


def test_a_missing_file_is_compiled_again(program: Program) -> None:
    for path in program.files(".nbc"):
        path.unlink()
    assert program.run() == ("8.0", True)
    assert program.run() == ("8.0", False)


def test_what_cannot_be_kept_is_no_error(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    assert kept_half(3.0) == (1.5, "compiled")


def test_of_two_processes_one_compiles_and_the_other_takes_what_it_kept(
    new_program: Program, first: Telling
) -> None:
    with new_program.start() as second:
        assert second.says() == "d3pg:waiting_for_kernel"
        second.go_on()
        first.go_on()
        assert first.says() == "numba:compile"  # the inner one
        first.go_on()
        assert first.says() == "8.0"
        assert second.says() == "8.0"


def test_the_kernel_of_a_process_that_was_killed_is_compiled_by_the_next(
    new_program: Program, first: Telling
) -> None:
    with new_program.start() as second:
        assert second.says() == "d3pg:waiting_for_kernel"
        second.go_on()
        first.kill()
        for _ in range(2):
            assert second.says() == "numba:compile"
            second.go_on()
        assert second.says() == "8.0"


def test_patience_with_a_suspended_process_has_an_end(new_program: Program, first: Telling) -> None:
    with new_program.start(patience_seconds=0.0) as second:
        for event in ("d3pg:waiting_for_kernel", "numba:compile", "numba:compile"):
            assert second.says() == event
            second.go_on()
        assert second.says() == "8.0"


def test_others_do_not_wait_for_a_kernel_that_cannot_be_compiled(folder: Path) -> None:
    kernel = kernel_of_half()
    with pytest.raises(numba.TypingError):
        kernel("text")
    (lock,) = folder.glob("*.lock")
    with FileLock(lock, blocking=False):  # raises Timeout where it is held
        pass
    assert kernel(3.0) == 1.5


def test_another_checkout_of_the_same_source_finds_the_kernels(
    program: Program, tmp_path_factory: pytest.TempPathFactory
) -> None:
    elsewhere = Program(tmp_path_factory.mktemp("elsewhere"))
    shutil.copytree(program.cache, elsewhere.cache)
    assert elsewhere.run() == ("8.0", False)
