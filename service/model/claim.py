"""A claim: one worker's right to train a cohort for as long as it keeps the lease."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from workers.messages.assignment import Assignment
from workers.messages.run_spec import COHORT_LIMIT, Cell, RunSpec

CellLimit = Callable[[Cell], int]
"""How many runs of a cell one worker may have at once."""


def no_limit(cell: Cell) -> int:
    """As many as a cohort ever has."""
    del cell
    return COHORT_LIMIT


@dataclass(frozen=True)
class ClaimedRun:
    """A run under the attempt that this claim opened."""

    run_id: str
    attempt: int
    spec: RunSpec
    environment_version: int


@dataclass(frozen=True)
class Claim:
    """Runs of one cell, claimed together.

    Every write under the claim carries the attempts and is refused for a run whose attempt has
    moved on (fencing), so a worker that was given up cannot write over its successor.
    """

    worker: str
    lease_seconds: float
    runs: tuple[ClaimedRun, ...]

    @property
    def name(self) -> str:
        """Names the claim: no other one holds its first run under the same attempt."""
        return f"{self.runs[0].run_id}/{self.runs[0].attempt}"

    @property
    def by_seed(self) -> Mapping[int, ClaimedRun]:
        """The runs by their seed, which is what a worker calls them."""
        return {run.spec.seed: run for run in self.runs}

    @property
    def specs(self) -> tuple[RunSpec, ...]:
        """The runs' specs."""
        return tuple(run.spec for run in self.runs)

    @property
    def assignments(self) -> tuple[Assignment, ...]:
        """What the worker is told."""
        return tuple(Assignment(run.run_id, run.attempt, run.spec) for run in self.runs)

    def only(self, run_ids: frozenset[str] | set[str]) -> "Claim":
        """Return the claim on those of its runs alone."""
        kept = tuple(run for run in self.runs if run.run_id in run_ids)
        return Claim(self.worker, self.lease_seconds, kept)

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal claim back."""
        return {
            "worker": self.worker,
            "lease_seconds": self.lease_seconds,
            "runs": [
                {
                    "run_id": run.run_id,
                    "attempt": run.attempt,
                    "spec": run.spec.to_json(),
                    "environment_version": run.environment_version,
                }
                for run in self.runs
            ],
        }

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Claim":
        """Read what `to_json` wrote."""
        runs = tuple(
            ClaimedRun(
                run["run_id"],
                run["attempt"],
                RunSpec.from_json(run["spec"]),
                run["environment_version"],
            )
            for run in document["runs"]
        )
        return cls(document["worker"], document["lease_seconds"], runs)
