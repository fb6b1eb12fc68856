"""A run as a value: everything its curve depends on, and nothing else.

Two equal specs give the same curve, bit for bit, on machines with the same fingerprint. Runs whose
specs differ in the seed alone share a *cell*; one worker trains up to `COHORT_LIMIT` of them at
once (a *cohort*).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

COHORT_LIMIT = 16


class Weights(NamedTuple):
    """Weights of the critic's gradient terms: w1 of the action's, w2 of the state's."""

    w1: float = 0.0
    w2: float = 0.0


NO_WEIGHTS = Weights()


@dataclass(frozen=True)
class RunSpec:
    """One run. `config` overrides the preset."""

    algorithm: str
    environment: str
    seed: int
    weights: Weights = NO_WEIGHTS
    timesteps: int = 40_000
    config: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def cell(self) -> "RunSpec":
        """What the runs of one curve share: the spec with the seed 0 stands for all of them."""
        return replace(self, seed=0)

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal spec back."""
        return {**vars(self), "weights": self.weights._asdict(), "config": dict(self.config)}

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "RunSpec":
        """Read what `to_json` wrote."""
        return cls(**{**document, "weights": Weights(**document["weights"])})


def shared_cell(specs: Sequence[RunSpec]) -> RunSpec:
    """Return the cell of a cohort.

    Raises ValueError when the specs are not a cohort: none, too many, of several cells, or with a
    seed twice.
    """
    if not 1 <= len(specs) <= COHORT_LIMIT:
        raise ValueError(f"a cohort is 1 to {COHORT_LIMIT} runs, got {len(specs)}")
    if len(cells := {spec.cell for spec in specs}) > 1:
        different = ", ".join(map(str, cells))
        raise ValueError(f"the runs of a cohort must differ only in their seed, got {different}")
    seeds = [spec.seed for spec in specs]
    if len(set(seeds)) < len(seeds):
        raise ValueError(f"the seeds of a cohort must be distinct, got {seeds}")
    return cells.pop()
