"""What a posted sweep asks for: its cells (curves) and its seeds, whose product are the runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from algorithms.measurement import MEASURE_EVERY
from algorithms.presets import completed, preset
from service.entry import Entries, Entry
from service.environment import environment_facts
from service.problems import Fault, InvalidRequest
from service.schemas.sweep_request import SweepRequest
from service.submission.check import cap_faults, name_faults, product_faults
from service.submission.memory import memory_faults
from service.submission.same_curve import notices, repetition_faults
from workers.run_spec import RunSpec


@dataclass(frozen=True)
class Plan:
    """A sweep before it is stored.

    cells    one spec per curve; its seed is the first one
    labels   of the entries that the cells are of
    seeds    of every cell
    notices  what whoever submits it should know
    """

    cells: tuple[RunSpec, ...]
    labels: tuple[str, ...]
    seeds: Sequence[int]
    notices: tuple[str, ...]

    @property
    def runs(self) -> int:
        """How many runs there will be."""
        return len(self.cells) * len(self.seeds)

    @property
    def timesteps(self) -> int:
        """Environment steps of all runs together."""
        return sum(cell.timesteps for cell in self.cells) * len(self.seeds)

    @property
    def algorithms(self) -> frozenset[str]:
        """Their names."""
        return frozenset(cell.algorithm for cell in self.cells)

    @property
    def environment_versions(self) -> Mapping[str, int]:
        """Under which version of its numbers each environment is run."""
        names = {cell.environment for cell in self.cells}
        return {name: environment_facts(name).version for name in names}

    def specs(self) -> list[RunSpec]:
        """Every run, those of a cell together: they are trained together."""
        return [replace(cell, seed=seed) for cell in self.cells for seed in self.seeds]


def plan(request: SweepRequest, worker_memory: int) -> Plan:
    """Return the plan of a sweep.

    Raises InvalidRequest with everything that is wrong: first for a product above the cap, which
    is counted and not expanded, then for what its parts and its cells ask, then for runs that would
    fill more than the worker's memory.
    """
    _refuse(cap_faults(request))
    seeds = range(request.seeds) if isinstance(request.seeds, int) else tuple(request.seeds)
    entries = Entries(request.model_dump(mode="json", exclude_unset=True))
    cells = [
        (entry, _spec(entry, environment, request, seeds[0]))
        for environment, entry in entries.cells
    ]
    _refuse([*name_faults(request), *product_faults(request), *repetition_faults(cells)])
    _refuse(list(memory_faults(cells, worker_memory)))
    return Plan(
        cells=tuple(spec for _, spec in cells),
        labels=tuple(entry.label for entry, _ in cells),
        seeds=seeds,
        notices=tuple(notices(cells)),
    )


def _refuse(faults: Sequence[Fault]) -> None:
    if faults:
        raise InvalidRequest(faults)


def _spec(entry: Entry, environment: str, request: SweepRequest, seed: int) -> RunSpec:
    """Return the entry's cell in one environment; what it does not state is the preset's."""
    usual = preset(entry.algorithm, environment)
    return RunSpec(
        algorithm=entry.algorithm,
        environment=environment,
        seed=seed,
        weights=usual.weights if entry.weights is None else entry.weights,
        timesteps=_scaled(request.timesteps or usual.timesteps, request.scale),
        config=completed(entry.algorithm, environment, entry.config),
    )


def _scaled(timesteps: int, scale: float) -> int:
    """Return that share of the timesteps, in whole measurements."""
    if scale == 1.0:
        return timesteps
    return max(round(scale * timesteps / MEASURE_EVERY), 1) * MEASURE_EVERY
