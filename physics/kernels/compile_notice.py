"""Compile notice: says on stderr that kernels are being compiled.

    compiling kernels for Pendulum (once on this machine) ........ 2.1 s

There is one dot for each kernel that this process or another one compiles. If all kernels come from
the cache, nothing is written.
"""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, TypeVar

from numba.core import event

from physics.kernels.cache import WAITING

T = TypeVar("T")

_events: Any = event  # without types
_COMPILING = ("numba:compile", WAITING)  # events; loading from the cache triggers neither


class _Notice(event.Listener):
    """The line of one wait: the first kernel begins it, each compiled kernel adds a dot."""

    def __init__(self, purpose: str, stream: TextIO) -> None:
        self.purpose = purpose
        self.stream = stream
        self.kernels = 0
        self.seconds = 0.0
        self._begun: list[float] = []  # nested: a kernel first compiles those that it calls

    def on_start(self, event: Any) -> None:
        """Begin the line, if this is the first kernel."""
        del event
        if not self.kernels and not self._begun:
            self._write(f"compiling kernels for {self.purpose} (once on this machine) ")
        self._begun.append(time.perf_counter())

    def on_end(self, event: Any) -> None:
        """Add the kernel's dot."""
        del event
        self.kernels += 1
        begun = self._begun.pop()
        if not self._begun:
            self.seconds += time.perf_counter() - begun
        self._write(".")

    def close(self) -> None:
        """End the line, if there is one."""
        if self.kernels:
            self._write(f" {self.seconds:.1f} s\n")

    def _write(self, text: str) -> None:
        self.stream.write(text)
        self.stream.flush()


@contextmanager
def compile_notice(purpose: str) -> Iterator[None]:
    """Write a notice, with the purpose, if kernels are compiled within this context."""
    notice = _Notice(purpose, sys.stderr)
    for kind in _COMPILING:
        _events.register(kind, notice)
    try:
        yield
    finally:
        for kind in _COMPILING:
            _events.unregister(kind, notice)
        notice.close()


def noticed(items: Iterator[T], purpose: str) -> Iterator[T]:
    """Yield the same items, with a notice if making the next one compiles kernels."""
    end = object()
    while True:
        with compile_notice(purpose):
            item = next(items, end)
        if item is end:
            return
        yield item  # type: ignore[misc]  # not the end
