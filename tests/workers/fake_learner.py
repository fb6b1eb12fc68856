"""A learner without learning: its measurements follow from seed and timestep."""

import threading
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from algorithms.early_end import Divergence, EarlyEnd
from algorithms.measurement import Measurement
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State
from workers.messages.run_spec import RunSpec

CYCLE = 100


def measurement_of(seed: int, timestep: int) -> Measurement:
    """What a seed measures there."""
    return Measurement(
        seed, timestep, -float(seed), -1.0 / timestep, timestep // 2, 0, 0.0, {}, 0.0
    )


class FakeLearner:
    """Trains until `timesteps`; `before_cycle(timestep)` may wait, raise, or diverge seeds."""

    bytes_per_run = 1000

    def __init__(
        self,
        specs: Sequence[RunSpec],
        before_cycle: Callable[[int], Collection[int]] = lambda _: (),
    ) -> None:
        self.seeds: list[int] = [spec.seed for spec in specs]
        self.timestep = 0
        self.thread = threading.current_thread()
        self._timesteps = specs[0].timesteps
        self._before_cycle = before_cycle

    @property
    def finished(self) -> bool:
        return not self.seeds or self.timestep >= self._timesteps

    def advance(self) -> list[Measurement | EarlyEnd]:
        diverging = self._before_cycle(self.timestep)
        self.timestep += CYCLE
        said: list[Measurement | EarlyEnd] = [
            Divergence(seed, self.timestep, self.timestep // 2, "critic loss")
            for seed in self.seeds
            if seed in diverging
        ]
        self.seeds = [seed for seed in self.seeds if seed not in diverging]
        return [*said, *(measurement_of(seed, self.timestep) for seed in self.seeds)]

    def drop(self, seeds: Collection[int]) -> None:
        self.seeds = [seed for seed in self.seeds if seed not in seeds]

    def state(self, seed: int) -> State:
        return {"timestep": np.array(self.timestep), "seed": np.array(seed)}

    def journal(self, seed: int, start: int) -> State:
        return {"lived": seed * 10**6 + np.arange(start, self.timestep)}

    def restore(self, saved: Mapping[int, Saved]) -> None:
        for seed, (state, journal) in saved.items():
            self.timestep = int(state["timestep"])
            assert state["seed"] == seed
            expected = seed * 10**6 + np.arange(self.timestep)
            np.testing.assert_array_equal(journal["lived"], expected, strict=True)

    def snapshot(self, seed: int) -> Snapshot | None:
        return None
