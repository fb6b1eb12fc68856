"""The points of one run, as arrays: what curves and figures are made of."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.model.processor import UNKNOWN
from service.model.run import RunStatus
from workers.messages.run_spec import RunSpec

RETURNS = ("return_mean", "return_history")
"""The metrics that every run has; any other is a diagnostic."""


@dataclass(frozen=True)
class RunCurve:
    """One metric of one run over one abscissa, in order of timestep.

    x          float64 [n]
    values     float64 [n], NaN and infinities as they were measured
    processor  that trained it (service.model.processor)
    entry      the place of its entry among those of its sweep
    """

    run_id: str
    spec: RunSpec
    environment_version: int
    status: RunStatus
    x: NDArray[np.float64]
    values: NDArray[np.float64]
    processor: str = UNKNOWN
    entry: int = 0
