"""Early ends: one run of a cohort ends before its timesteps, and the others continue.

An error in one run is an exception in a call for this run alone. A number that is not finite ends
the run as diverged, any other error as failed.
"""

from collections.abc import Sequence
from dataclasses import dataclass


class NotFiniteQuantityError(ArithmeticError):
    """A quantity of a run is NaN or infinite.

    Attributes:
        quantity: its name.
    """

    def __init__(self, quantity: str) -> None:
        """Name the quantity."""
        self.quantity = quantity
        super().__init__(f"{quantity} not finite")


@dataclass(frozen=True)
class Divergence:
    """A run that ended because a quantity stopped being finite.

    Attributes:
        seed: the run's seed.
        timestep: environment steps taken so far.
        update: number of the update in which it happened, from 1 on; if it happened between two
            updates, that of the later one.
        quantity: what is not finite.
    """

    seed: int
    timestep: int
    update: int
    quantity: str

    @property
    def reason(self) -> str:
        """A sentence's end: what happened, and when."""
        where = f"update {self.update}, timestep {self.timestep:,}"
        return f"diverged: {self.quantity} not finite at {where}"


@dataclass(frozen=True)
class Failure:
    """A run that ended because code raised in a call for this run alone.

    Attributes:
        seed: the run's seed.
        timestep: environment steps taken so far.
        error: the traceback; its last line names the error.
    """

    seed: int
    timestep: int
    error: str

    @property
    def reason(self) -> str:
        """A sentence's end: what happened, and when."""
        last_line = self.error.strip().rpartition("\n")[2]
        return f"failed at timestep {self.timestep:,}: {last_line}"


EarlyEnd = Divergence | Failure


class DivergedError(ArithmeticError):
    """Some runs diverged; the others were trained to their end.

    Attributes:
        divergences: one for each diverged run.
    """

    def __init__(self, divergences: Sequence[Divergence]) -> None:
        """Say which runs diverged, where and how."""
        self.divergences = list(divergences)
        super().__init__("; ".join(f"seed {end.seed} {end.reason}" for end in divergences))


class FailedRunsError(RuntimeError):
    """Code raised in some runs; the others were trained to their end.

    Attributes:
        failures: one for each failed run.
        divergences: one for each run that diverged.
    """

    def __init__(self, failures: Sequence[Failure], divergences: Sequence[Divergence]) -> None:
        """Say which runs failed and how, with the traceback of the first."""
        self.failures, self.divergences = list(failures), list(divergences)
        early: list[EarlyEnd] = [*failures, *divergences]
        ends = "; ".join(f"seed {end.seed} {end.reason}" for end in early)
        super().__init__(f"{ends}\n\nThe first failure:\n{failures[0].error}")
