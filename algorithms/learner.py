"""Learner: the one face that every algorithm shows to whoever runs it."""

from collections.abc import Collection, Sequence
from typing import Protocol

from algorithms.measurement import Divergence, Measurement


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
    def finished(self) -> bool:
        """Whether nothing is left to do."""

    def advance(self) -> list[Measurement | Divergence]:
        """Train a little further, well under a second; a diverged run leaves the cohort."""

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds, such as cancelled ones; unknown ones are ignored."""
