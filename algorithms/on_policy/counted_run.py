"""CountedRun: the base of all on-policy runs, with counters, a history and a state of parts."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, Protocol

import numpy as np

from algorithms.history import History
from algorithms.measurement import Measurement
from algorithms.state import State, fill, part, within


class Part(Protocol):
    """An object with its own state."""

    def state(self) -> State:
        """Its state."""

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""


class CountedRun:
    """A run without its policy; see `algorithms.on_policy.learner.Run`.

    Attributes:
        counters: names of the attributes that are whole numbers, saved in checkpoints.
        learned: names of further attributes on which the next bits depend, arrays and numbers.
        seed: the run's seed.
        history: its measurements.
        timestep: environment steps so far.
        jacobians: Jacobians so far.
        updates: updates so far.
    """

    counters: ClassVar[Sequence[str]] = ("timestep", "jacobians", "updates")
    learned: ClassVar[Sequence[str]] = ()

    def __init__(self, seed: int, timesteps: int) -> None:
        """Begin a run of `timesteps`."""
        self.seed = seed
        self.history = History(seed, timesteps)
        self.timestep = self.jacobians = self.updates = 0
        self._timesteps = timesteps

    @property
    def is_over(self) -> bool:
        """Whether it has used its timesteps."""
        return self.timestep >= self._timesteps

    def diagnostics(self) -> dict[str, float]:
        """Further numbers of a measurement, by name."""
        return {}

    def parts(self) -> Mapping[str, Part]:
        """The parts, by name, on which its next bits also depend."""
        return {}

    def measured(self, return_mean: float) -> Measurement:
        """Return the next measurement, with this return."""
        self.history.record(return_mean)
        return self.history.measured(
            updates=self.updates, jacobians=self.jacobians, diagnostics=self.diagnostics()
        )

    def state(self) -> State:
        """All values on which its next bits depend."""
        learned = {name: np.asarray(getattr(self, name)) for name in self.learned}
        state = {
            "counters": np.array([getattr(self, name) for name in self.counters]),
            **within("learned", learned),
            **within("history", self.history.state()),
        }
        for name, each in self.parts().items():
            state |= within(name, each.state())
        return state

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        for name, number in zip(self.counters, state["counters"].tolist(), strict=True):
            setattr(self, name, number)
        for name, array in part(state, "learned").items():
            own = getattr(self, name)
            if isinstance(own, np.ndarray):
                fill(own, array)
            else:
                setattr(self, name, array.item())
        self.history.restore(part(state, "history"))
        for name, each in self.parts().items():
            each.restore(part(state, name))
