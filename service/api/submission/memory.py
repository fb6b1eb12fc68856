"""Runs that no worker has the memory for."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from service.api.refusals.problems import Fault
from service.model.request.entry import Entry
from service.queue.worker_memory import memory_of
from workers.messages.run_spec import RunSpec

SETTING = "D3PG_WORKER_MEMORY"


def memory_faults(cells: Iterable[tuple[Entry, RunSpec]], worker_memory: int) -> Iterator[Fault]:
    """Refuse cells, each with its entry, of which not one run fits a worker."""
    for entry, cell in cells:
        needed = memory_of(cell)
        if needed <= worker_memory:
            continue
        what = f"a run of {cell.algorithm} on {cell.environment} needs up to {_text(needed)}"
        limit = f"the runs of a worker may fill {_text(worker_memory)} ({SETTING})"
        a_step = memory_of(replace(cell, timesteps=1))
        if a_step < needed:  # it grows with the timesteps
            most = worker_memory // a_step
            advice = f"ask for at most {most:,} timesteps, or set its replay_size to no more"
            yield Fault("timesteps", f"{what} with {entry.field}, but {limit}: {advice}", most)
        else:
            yield Fault(entry.field, f"{what}, but {limit}", worker_memory)


def _text(size: int) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 10**9 else f"{size / 1e6:.1f} MB"
