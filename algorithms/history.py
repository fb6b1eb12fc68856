"""History: the measurements of one run on the grid of timesteps that all algorithms share.

The grid is every `MEASURE_EVERY` timesteps, and the run's last timestep.
"""

import math
from collections import deque
from collections.abc import Mapping

import numpy as np

from algorithms.measurement import HISTORY, MEASURE_EVERY, Measurement
from algorithms.state import State
from algorithms.stopwatch import Cost


class History:
    """The measurements of one run.

    Attributes:
        seed: the run's seed.
        count: measurements so far.
        returns: the latest `HISTORY` returns recorded, oldest first.
        cost: the run's cost so far.
    """

    def __init__(self, seed: int, timesteps: int) -> None:
        """Begin without measurements, in a run of `timesteps`."""
        self.seed = seed
        self._timesteps = timesteps
        self.count = 0
        self.returns = deque[float](maxlen=HISTORY)
        self.cost = Cost()

    @property
    def is_complete(self) -> bool:
        """Whether the last timestep has been measured."""
        return self.count * MEASURE_EVERY >= self._timesteps

    def due(self, timestep: int) -> range:
        """Numbers, from 1 on, of the measurements due up to and including a timestep."""
        at_end = timestep >= self._timesteps
        last = math.ceil(self._timesteps / MEASURE_EVERY) if at_end else timestep // MEASURE_EVERY
        return range(self.count + 1, last + 1)

    def state(self) -> State:
        """Its state, without the seed."""
        return {
            "count": np.array(self.count),
            "returns": np.array(self.returns, np.float64),
            **self.cost.state(),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        self.count = int(state["count"])
        self.returns = deque(state["returns"].tolist(), HISTORY)
        self.cost.restore(state)

    def record(self, return_mean: float) -> None:
        """Record the current return of the run."""
        self.returns.append(return_mean)

    def measured(
        self, *, updates: int, jacobians: int, diagnostics: Mapping[str, float]
    ) -> Measurement:
        """The next measurement, with the last recorded return."""
        self.count += 1
        return Measurement(
            seed=self.seed,
            timestep=min(self.count * MEASURE_EVERY, self._timesteps),
            return_mean=self.returns[-1],
            return_history=float(np.mean(self.returns)),
            updates=updates,
            jacobians=jacobians,
            seconds=self.cost.seconds,
            compile_seconds=self.cost.compile_seconds,
            diagnostics=diagnostics,
        )
