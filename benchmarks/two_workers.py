"""Two workers: the speed of two workers over that of one; the ideal is 2.

16 seeds of hybrid-ddpg on Pendulum are trained by `workers/training/execute.py`, in one process
alone and then in two at once, each on one thread, with warm kernels. The rate is that of updates of
all seeds together per second of wall time, from the first report of measurements to the last:
loading and compiling are not included.

    python -m benchmarks.two_workers [TIMESTEPS]
"""

import multiprocessing
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.synchronize import Barrier
from pathlib import Path

from workers.messages.assignment import Assignment
from workers.messages.run_spec import COHORT_LIMIT, RunSpec, Weights
from workers.training.execute import execute

TIMESTEPS = 20_000
ROUNDS = 3
NEWS_SECONDS = 0.05
WEIGHTS = Weights(0.1, 0.1)

_start: Barrier | None = None  # one per process


def main() -> None:
    """Print the best rate of one worker and of two, and their ratio."""
    timesteps = int(sys.argv[1]) if len(sys.argv) > 1 else TIMESTEPS
    together(1, 1600)  # compiles the kernels, if they are not cached
    one = max(together(1, timesteps) for _ in range(ROUNDS))
    two = max(together(2, timesteps) for _ in range(ROUNDS))
    report("one worker", one, "seed-updates/s")
    report("two workers", two, "seed-updates/s")
    report("two workers / one, at best 2", two / one, "")


def together(workers: int, timesteps: int) -> float:
    """Seed-updates per second of `workers` processes at once, in total."""
    context = multiprocessing.get_context("spawn")  # forked, they would share the BLAS's threads
    start = context.Barrier(workers)
    with ProcessPoolExecutor(workers, context, initializer=keep, initargs=(start,)) as processes:
        return sum(processes.map(train, [timesteps] * workers))


def keep(start: Barrier) -> None:
    """Store the barrier at which all processes start."""
    global _start  # noqa: PLW0603  (a barrier cannot be an argument of a task)
    _start = start


def train(timesteps: int) -> float:
    """Train a cohort, starting with the others; return its seed-updates per second."""
    specs = [
        RunSpec("hybrid-ddpg", "Pendulum", seed, WEIGHTS, timesteps) for seed in range(COHORT_LIMIT)
    ]
    runs = [Assignment(f"run-{spec.seed}", 1, spec, 1) for spec in specs]
    assert _start is not None
    _start.wait()
    with tempfile.TemporaryDirectory() as folder:
        told = execute(runs, Path(folder), tuple, abandoned, report_seconds=NEWS_SECONDS)
        news = [(time.perf_counter(), progress.measurements) for progress in told]
    (begun, first), *_, (ended, last) = [each for each in news if each[1]]
    updates = {m.seed: m.updates for m in last}
    before = {m.seed: m.updates for m in first}
    return sum(updates[seed] - before[seed] for seed in updates) / (ended - begun)


def abandoned() -> None:
    """Raise an error: nobody abandons the runs, since every message is accepted at once."""
    raise AssertionError("nobody listened")


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.4g} {unit}".rstrip(), flush=True)


if __name__ == "__main__":
    main()
