"""What a posted sweep asks for: its cells (curves) and its seeds, whose product are the runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from algorithms.measurement import MEASURE_EVERY
from algorithms.presets import preset
from service.environment import environment_facts
from service.problems import InvalidRequest
from service.schemas.sweep_request import AlgorithmRequest, SweepRequest, Weights
from service.submission.check import cap_faults, name_faults, product_faults
from service.submission.memory import memory_faults
from workers.run_spec import RunSpec


@dataclass(frozen=True)
class Plan:
    """A sweep before it is stored.

    cells  one spec per curve; its seed is the first one
    seeds  of every cell
    """

    cells: tuple[RunSpec, ...]
    seeds: Sequence[int]

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
    is counted and not expanded, then for names, then for what each cell asks, then for runs that
    would fill more than the worker's memory.
    """
    for faults_of in (cap_faults, name_faults, product_faults):
        if faults := faults_of(request):
            raise InvalidRequest(faults)
    seeds = range(request.seeds) if isinstance(request.seeds, int) else tuple(request.seeds)
    cells = [
        (f"algorithms[{i}]", cell)
        for environment in request.environments
        for i, algorithm in enumerate(request.algorithms)
        if algorithm.runs_in(environment)
        for cell in _cells(algorithm, environment, request, seeds[0])
    ]
    if faults := list(memory_faults(cells, worker_memory)):
        raise InvalidRequest(faults)
    return Plan(tuple(cell for _, cell in cells), seeds)


def _cells(
    algorithm: AlgorithmRequest, environment: str, request: SweepRequest, seed: int
) -> Iterator[RunSpec]:
    """Yield a cell per pair of weights; what is not named is the preset's."""
    usual = preset(algorithm.name, environment)
    timesteps = _scaled(request.timesteps or usual.timesteps, request.scale)
    asked = algorithm.weights
    if asked is None:
        pairs = [usual.weights]
    else:
        listed = [asked] if isinstance(asked, Weights) else asked
        pairs = [(weights.w1, weights.w2) for weights in listed]
    for weights in pairs:
        yield RunSpec(
            algorithm=algorithm.name,
            environment=environment,
            seed=seed,
            weights=weights,
            timesteps=timesteps,
            config={**usual.config, **algorithm.config},
        )


def _scaled(timesteps: int, scale: float) -> int:
    """Return that share of the timesteps, in whole measurements."""
    if scale == 1.0:
        return timesteps
    return max(round(scale * timesteps / MEASURE_EVERY), 1) * MEASURE_EVERY
