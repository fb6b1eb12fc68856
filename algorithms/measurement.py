"""Measurement: a learner's report of a run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

MEASURE_EVERY = 800
"""Timesteps between measurements (section 5.2)."""
HISTORY = 100
"""The number of measurements in the mean `return_history`."""


@dataclass(frozen=True)
class Measurement:
    """One point of a run's curves.

    Attributes:
        seed: the run's seed.
        timestep: environment steps taken so far, evaluation not counted.
        return_mean: undiscounted return of one episode of the deterministic actor.
        return_history: mean of the latest 100 `return_mean`, or of all if there are fewer.
        updates: updates done so far.
        jacobians: Jacobians of transitions computed so far, including those for diagnostics.
        seconds: processor time of training so far: acting and learning, without evaluation,
            diagnostics, checkpoints and waiting. The cost of what a cohort does together is divided
            evenly among its runs.
        diagnostics: further numbers by name; NaN where a number does not exist.
        compile_seconds: processor time so far of compiling kernels and loading them from the cache,
            divided evenly among the runs of a cohort, and not part of `seconds`. NaN for
            measurements of an earlier version, whose `seconds` are wall time and include it.
    """

    seed: int
    timestep: int
    return_mean: float
    return_history: float
    updates: int
    jacobians: int
    seconds: float
    diagnostics: Mapping[str, float]
    compile_seconds: float = math.nan
