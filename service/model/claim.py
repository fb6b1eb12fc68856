"""A claim: one worker's right to train a cohort for as long as it keeps the lease."""

from collections.abc import Callable
from dataclasses import dataclass

from workers.messages.assignment import Assignment
from workers.messages.run_spec import COHORT_LIMIT, RunSpec

CellLimit = Callable[[RunSpec], int]
"""How many runs of a cell one worker may have at once."""


def no_limit(cell: RunSpec) -> int:
    """The most that a cohort has."""
    del cell
    return COHORT_LIMIT


@dataclass(frozen=True)
class Claim:
    """Runs of one cell, claimed together; each attempt was opened by this claim.

    Every write under the claim carries the attempts and is refused for a run whose attempt has
    moved on (fencing), so a worker that was given up cannot write over its successor.
    """

    worker: str
    lease_seconds: float
    runs: tuple[Assignment, ...]

    @property
    def name(self) -> str:
        """Names the claim: no other one holds its first run under the same attempt."""
        return f"{self.runs[0].run_id}/{self.runs[0].attempt}"

    @property
    def specs(self) -> tuple[RunSpec, ...]:
        """The runs' specs."""
        return tuple(run.spec for run in self.runs)

    def only(self, run_ids: frozenset[str] | set[str]) -> "Claim":
        """Return the claim on only those of its runs."""
        kept = tuple(run for run in self.runs if run.run_id in run_ids)
        return Claim(self.worker, self.lease_seconds, kept)
