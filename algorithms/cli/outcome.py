"""Outcome: the results of the runs of one training so far."""

from collections.abc import Iterable, Sequence

import numpy as np

from algorithms.early_end import EarlyEnd
from algorithms.measurement import Measurement


class Outcome:
    """The latest results of each run.

    Attributes:
        seeds: all runs, including those not measured yet.
        latest: by seed, its last measurement.
        ended: by seed, how it ended early.
    """

    def __init__(self, seeds: Sequence[int]) -> None:
        """Begin with nothing measured."""
        self.seeds = list(seeds)
        self.latest: dict[int, Measurement] = {}
        self.ended: dict[int, EarlyEnd] = {}

    def take(self, events: Iterable[Measurement | EarlyEnd]) -> list[Measurement]:
        """Add a learner's events; return the measurements among them."""
        measured = []
        for event in events:
            if isinstance(event, Measurement):
                self.latest[event.seed] = event
                measured.append(event)
            else:
                self.ended[event.seed] = event
        return measured

    def returns(self, name: str) -> list[float]:
        """The latest `return_mean` or `return_history` of every run measured, ended or not."""
        return [getattr(measurement, name) for measurement in self.latest.values()]

    @property
    def mean_text(self) -> str:
        """The mean over the runs, as text: `mean return -151.3 (16 seeds)`."""
        returns = self.returns("return_mean")
        if not returns:
            return "nothing measured yet"
        plural = "" if len(returns) == 1 else "s"
        return f"mean return {np.mean(returns):,.2f} ({len(returns)} seed{plural})"
