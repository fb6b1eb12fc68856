"""Learner: the one face that every algorithm shows to whoever runs it.

A run can be left and taken up again, between two calls of `advance`, to the same bits:

    saved = {seed: Saved(learner.state(seed), learner.journal(seed, 0)) for seed in learner.seeds}
    other = build(...)                                      # the same arguments, these seeds
    other.restore(saved)                                    # other.advance() does as learner's

The state is small and saved whole. The journal, a row for each timestep, only grows: whoever saves
a run a second time asks for the rows since the first. What can be worked out again from the journal
(features, rewards, Jacobians: functions of state and action) is in neither.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

from algorithms.early_end import EarlyEnd
from algorithms.measurement import Measurement
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State


class Learner(Protocol):
    """A cohort of runs in training, which differ in their seed alone.

    No run feels its neighbours: its measurements depend on its own seed alone, bit for bit.
    """

    @property
    def seeds(self) -> Sequence[int]:
        """The seeds still in training."""

    @property
    def timestep(self) -> int:
        """Environment steps each of them has taken."""

    @property
    def bytes_per_run(self) -> int:
        """Memory that each of them may come to fill, but for the small change."""

    @property
    def finished(self) -> bool:
        """Whether nothing is left to do."""

    def advance(self) -> list[Measurement | EarlyEnd]:
        """Train a little further, well under a second; a run that ends early leaves the cohort."""

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds, such as cancelled ones; unknown ones are ignored."""

    def state(self, seed: int) -> State:
        """All that the run's next bits depend on but its journal; copy it before `advance`."""

    def journal(self, seed: int, start: int) -> State:
        """The journal's rows of timesteps `start` to `timestep`, arrays `[timestep - start, ...]`.

        Without the oldest of them, where they are no longer needed. Empty for learners that keep
        no journal.
        """

    def restore(self, saved: Mapping[int, Saved]) -> None:
        """Take up every run of a learner just built, all left at the same timestep.

        Raises:
            KeyError, ValueError: for a state that is not of this learner.
        """

    def snapshot(self, seed: int) -> Snapshot | None:
        """What was learned so far, to act and to look at; None for those that learn no policy.

        Also of a run that has just ended: that is when its last snapshot is taken.
        """
