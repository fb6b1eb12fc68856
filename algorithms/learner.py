"""Learner: the interface of every algorithm.

A run can be saved and restored between two calls of `advance`, and continues with the same bits:

    saved = {seed: Saved(learner.state(seed), learner.journal(seed, 0)) for seed in learner.seeds}
    other = build(...)                                      # the same arguments, these seeds
    other.restore(saved)                                    # other.advance() equals learner's

The state is small and saved whole. The journal has a row for each timestep and only grows: a second
save needs only the rows since the first. Neither contains what can be recomputed from the journal
(features, rewards, Jacobians: functions of state and action).
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

from algorithms.early_end import EarlyEnd
from algorithms.measurement import Measurement
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State


class Learner(Protocol):
    """A cohort of runs in training, which differ only in their seed.

    The measurements of a run depend on its own seed only, bit for bit.
    """

    @property
    def seeds(self) -> Sequence[int]:
        """The seeds still in training."""

    @property
    def timestep(self) -> int:
        """Environment steps that each of them has taken."""

    @property
    def bytes_per_run(self) -> int:
        """Memory in bytes that each of them may fill, without small objects."""

    @property
    def finished(self) -> bool:
        """Whether nothing is left to do."""

    def advance(self) -> list[Measurement | EarlyEnd]:
        """Train for well under a second; return what was measured and which runs ended early.

        A run that ends early leaves the cohort.
        """

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds, such as cancelled ones; unknown ones are ignored."""

    def state(self, seed: int) -> State:
        """Everything on which the run's next bits depend except the journal, as arrays by name.

        The next `advance` may overwrite the arrays.
        """

    def journal(self, seed: int, start: int) -> State:
        """The journal's rows of timesteps `start` to `timestep`, arrays `[timestep - start, ...]`.

        The oldest rows are missing if they are no longer needed. Empty for learners without a
        journal.
        """

    def restore(self, saved: Mapping[int, Saved]) -> None:
        """Restore every run of a learner that was just built, all saved at the same timestep.

        Raises:
            KeyError, ValueError: for a state of another learner.
        """

    def snapshot(self, seed: int) -> Snapshot | None:
        """The policy and critic learned so far; None for learners without a policy.

        Also available for a run that has just ended, whose last snapshot is taken then.
        """
