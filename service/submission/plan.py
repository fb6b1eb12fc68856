"""What a posted sweep asks for: its cells (curves) and its seeds, whose product are the runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from service.algorithm import AlgorithmFacts, algorithm_facts
from service.environment import environment_facts
from service.problems import InvalidRequest
from service.schemas.sweep_request import AlgorithmRequest, SweepRequest, Weights
from service.submission.check import cap_faults, name_faults, product_faults
from workers.run_spec import RunSpec

PRESET_WEIGHTS = (0.1, 0.1)
PRESET_TIMESTEPS = 40_000


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
    def environment_versions(self) -> Mapping[str, int]:
        """Under which version of its numbers each environment is run."""
        names = {cell.environment for cell in self.cells}
        return {name: environment_facts(name).version for name in names}

    def specs(self) -> list[RunSpec]:
        """Every run, those of a cell together: they are trained together."""
        return [replace(cell, seed=seed) for cell in self.cells for seed in self.seeds]


def plan(request: SweepRequest) -> Plan:
    """Return the plan of a sweep.

    Raises InvalidRequest with everything that is wrong: first for a product above the cap, which
    is counted and not expanded, then for names, then for what each cell asks.
    """
    for faults_of in (cap_faults, name_faults, product_faults):
        if faults := faults_of(request):
            raise InvalidRequest(faults)
    seeds = range(request.seeds) if isinstance(request.seeds, int) else tuple(request.seeds)
    cells = [
        RunSpec(
            algorithm=algorithm.name,
            environment=environment,
            seed=seeds[0],
            weights=weights,
            timesteps=request.timesteps or PRESET_TIMESTEPS,
            config=algorithm.config,
        )
        for environment in request.environments
        for algorithm in request.algorithms
        for weights in _weights(algorithm, algorithm_facts(algorithm.name))
    ]
    return Plan(tuple(cells), seeds)


def _weights(asked: AlgorithmRequest, facts: AlgorithmFacts) -> list[tuple[float, float]]:
    if not facts.uses_weights:
        return [(0.0, 0.0)]
    if asked.weights is None:
        return [PRESET_WEIGHTS]
    listed = [asked.weights] if isinstance(asked.weights, Weights) else asked.weights
    return [(weights.w1, weights.w2) for weights in listed]
