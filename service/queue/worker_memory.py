"""Memory of workers: how much the runs of one may fill, and how many runs of a cell that is.

    runs at once = min(16, worker memory / memory of a run)

By default a worker's runs may fill four fifths of the machine's memory divided by the workers, less
what a worker's process takes by itself. Runs give the same bits in any cohort, so a smaller one
costs time alone.
"""

import os
from functools import lru_cache
from pathlib import Path

from algorithms.memory import bytes_per_run
from service.model.environment import environment_facts
from workers.messages.run_spec import COHORT_LIMIT, RunSpec

SHARE = 0.8
PROCESS_BYTES = 300 * 2**20
"""What a worker takes before it has learned anything: libraries and compiled kernels."""
LEAST_BYTES = 2**20
CONTAINER_LIMIT = Path("/sys/fs/cgroup/memory.max")


def usual_worker_memory(workers: int) -> int:
    """Bytes that the runs of each of so many workers on this machine may fill."""
    share = int(SHARE * machine_memory() / workers)
    return max(share - PROCESS_BYTES, share // 2, LEAST_BYTES)


def machine_memory(container_limit: Path = CONTAINER_LIMIT) -> int:
    """Bytes of memory that this machine has, or that its container may use."""
    physical = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    try:
        return min(physical, int(container_limit.read_text()))
    except (OSError, ValueError):  # no container, or one that says "max"
        return physical


def runs_at_once(cell: RunSpec, worker_memory: int) -> int:
    """How many runs of a cell a worker takes at once; one that is too large is taken alone."""
    try:
        each = memory_of(cell)
    except Exception:  # what its package raises, or is missing: its worker will say so
        return COHORT_LIMIT
    return COHORT_LIMIT if each == 0 else max(1, min(COHORT_LIMIT, worker_memory // each))


@lru_cache(maxsize=1024)
def memory_of(cell: RunSpec) -> int:
    """Bytes that each run of a cell needs. Raises ValueError for settings that no learner takes."""
    return bytes_per_run(
        cell.algorithm,
        environment_facts(cell.environment),
        cell.weights,
        cell.timesteps,
        cell.config,
    )
