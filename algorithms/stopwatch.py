"""Stopwatch: the cost of training a cohort, run by run, in processor time.

    seconds          of training: acting and learning
    compile_seconds  of compiling kernels, and of loading them from numba's cache

Both are measured by the clock of the training thread, which stops while the thread waits: other
work on the machine does not count, except for its effect on caches and on the core's speed. Kernels
are compiled or loaded in their first calls, wherever these are; meanwhile numba holds a lock, and
triggers events for it.

Anything else is not counted: evaluation episodes, diagnostics, checkpoints.
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
    """The depth of a thread's calls of the compiler, their start, and the time spent before."""

    depth = 0  # nested: a kernel first compiles those that it calls
    begun = 0.0
    seconds = 0.0


class _Compiler(event.Listener):
    """Counts the processor time that the calling thread spends in numba's compiler."""

    def __init__(self) -> None:
        self._own = _OfThread()

    @property
    def seconds(self) -> float:
        """The seconds of the calling thread so far."""
        return self._own.seconds

    def on_start(self, event: Any) -> None:
        """Begin, unless the compiler called itself."""
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
    """The cost of one run so far.

    Attributes:
        seconds: seconds of training; a resumed run continues from the value in its checkpoint.
        compile_seconds: seconds for its kernels, in every process that has trained it.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self.seconds = 0.0
        self.compile_seconds = 0.0

    def state(self) -> State:
        """Both numbers."""
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
        costs: the costs of the runs in training, by seed.
    """

    def __init__(self, costs: Mapping[int, Cost]) -> None:
        """Add to these costs from now on."""
        self.costs = dict(costs)

    def keep(self, seeds: Collection[int]) -> None:
        """Count only for these seeds: the others have left the cohort."""
        self.costs = {seed: self.costs[seed] for seed in seeds}

    @contextmanager
    def training(self, seeds: Collection[int]) -> Iterator[None]:
        """Count this context as training, shared evenly by these runs.

        The time of kernels that are compiled or loaded in it is shared evenly by all runs. These
        contexts must not be nested.
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
        """Count only the kernels compiled or loaded in this context: it is not training."""
        return self.training(())
