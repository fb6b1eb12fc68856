"""What a learner says about one of its runs."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Measurement:
    """One point of a run's learning curve.

    seed            which run of the cohort
    timestep        environment steps done
    return_mean     undiscounted return of one episode of the current deterministic actor
    return_history  mean of the latest 100 return_mean
    updates         gradient updates done
    jacobians       Jacobian evaluations done
    seconds         wall time of the run's own work
    diagnostics     further numbers, by name
    """

    seed: int
    timestep: int
    return_mean: float
    return_history: float
    updates: int
    jacobians: int
    seconds: float
    diagnostics: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Divergence:
    """A quantity of a run stopped being finite, at this update."""

    seed: int
    timestep: int
    update: int
    quantity: str
