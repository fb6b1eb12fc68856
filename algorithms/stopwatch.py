"""Stopwatch: what training a cohort costs, run by run, in processor time.

    seconds          of training: acting and learning
    compile_seconds  of compiling kernels, and of loading them from numba's cache

Both are by the clock of the thread that trains, which stands still while the thread waits: work
beside it does not count, but for what it takes of the caches and of the core's pace. Kernels are
compiled or loaded within their first calls, wherever those are; numba holds a lock meanwhile, and
says so.

What is neither of the two is not counted: evaluation episodes, diagnostics, checkpoints.
"""

import threading
import time
from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import numpy as np
from numba.core import event

from algorithms.state import State

_events: Any = event  # without types
_COMPILER_LOCK = "numba:compiler_lock"  # numba's event; held to compile a kernel and to load one


class _OfThread(threading.local):
    """How deep in the compiler a thread is, since when, and how long it was there before."""

    depth = 0  # a kernel compiles those that it calls before itself
    begun = 0.0
    seconds = 0.0


class _Compiler(event.Listener):
    """Counts the processor time that the calling thread spends in numba's compiler."""

    def __init__(self) -> None:
        self._own = _OfThread()

    @property
    def seconds(self) -> float:
        """Of the calling thread, so far."""
        return self._own.seconds

    def on_start(self, event: Any) -> None:
        """Begin, unless the compiler was called by itself."""
        del event
        if not self._own.depth:
            self._own.begun = time.thread_time()
        self._own.depth += 1

    def on_end(self, event: Any) -> None:
        """End what `on_start` began."""
        del event
        self._own.depth -= 1
        if not self._own.depth:
            self._own.seconds += time.thread_time() - self._own.begun


_COMPILER = _Compiler()
_events.register(_COMPILER_LOCK, _COMPILER)


class Cost:
    """What one run has cost so far.

    Attributes:
        seconds: of training; what a resumed run had cost by its checkpoint counts on.
        compile_seconds: of its kernels, in every process that has trained it.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self.seconds = 0.0
        self.compile_seconds = 0.0

    def state(self) -> State:
        """All of it."""
        return {
            "seconds": np.array(self.seconds),
            "compile_seconds": np.array(self.compile_seconds),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned, and add what this process has compiled so far."""
        self.seconds = float(state["seconds"])
        self.compile_seconds += float(state["compile_seconds"])


class Stopwatch:
    """Shares the time of a cohort among its runs.

    Attributes:
        costs: of the runs in training, by seed.
    """

    def __init__(self, costs: Mapping[int, Cost]) -> None:
        """Add to these from now on."""
        self.costs = dict(costs)

    def keep(self, seeds: Collection[int]) -> None:
        """Count for these only: the others have left the cohort."""
        self.costs = {seed: self.costs[seed] for seed in seeds}

    @contextmanager
    def training(self, seeds: Collection[int]) -> Iterator[None]:
        """Count what is done within as training, shared evenly by these runs.

        What is compiled or loaded meanwhile serves all, and is shared evenly by all. Not nested.
        """
        begun, compiled = time.thread_time(), _COMPILER.seconds
        try:
            yield
        finally:
            compiling = _COMPILER.seconds - compiled
            trained = time.thread_time() - begun - compiling
            for seed in seeds:
                self.costs[seed].seconds += trained / len(seeds)
            for cost in self.costs.values():
                cost.compile_seconds += compiling / len(self.costs)

    def aside(self) -> AbstractContextManager[None]:
        """Count what is compiled or loaded within, and nothing else: it is not training."""
        return self.training(())
