"""A run as a value: everything its curve depends on, and nothing else.

Two equal specs give the same curve, bit for bit, on machines with the same fingerprint. Runs whose
specs differ in the seed alone share a *cell*; one worker trains up to `COHORT_LIMIT` of them at
once (a *cohort*).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

COHORT_LIMIT = 16


class Cell(NamedTuple):
    """What runs of one curve share: the whole spec but the seed. Hashable and ordered."""

    algorithm: str
    environment: str
    weights: tuple[float, float]
    timesteps: int
    config: str  # canonical JSON


@dataclass(frozen=True)
class RunSpec:
    """One run. `weights` are (w1, w2) of the gradient terms; `config` overrides the preset."""

    algorithm: str
    environment: str
    seed: int
    weights: tuple[float, float] = (0.0, 0.0)
    timesteps: int = 40_000
    config: Mapping[str, Any] = field(default_factory=dict)

    @property
    def cell(self) -> Cell:
        """The spec without its seed."""
        return Cell(
            self.algorithm,
            self.environment,
            self.weights,
            self.timesteps,
            json.dumps(self.config, sort_keys=True, separators=(",", ":"), allow_nan=False),
        )

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal spec back."""
        return {
            "algorithm": self.algorithm,
            "environment": self.environment,
            "seed": self.seed,
            "weights": {"w1": self.weights[0], "w2": self.weights[1]},
            "timesteps": self.timesteps,
            "config": dict(self.config),
        }

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "RunSpec":
        """Read what `to_json` wrote."""
        weights = document["weights"]
        return cls(
            algorithm=document["algorithm"],
            environment=document["environment"],
            seed=document["seed"],
            weights=(weights["w1"], weights["w2"]),
            timesteps=document["timesteps"],
            config=dict(document["config"]),
        )


def shared_cell(specs: Sequence[RunSpec]) -> Cell:
    """Return the cell of a cohort.

    Raises ValueError when the specs are not a cohort: none, too many, of several cells, or with a
    seed twice.
    """
    if not 1 <= len(specs) <= COHORT_LIMIT:
        raise ValueError(f"a cohort is 1 to {COHORT_LIMIT} runs, got {len(specs)}")
    cells = {spec.cell for spec in specs}
    if len(cells) > 1:
        raise ValueError(f"the runs of a cohort differ in their seed alone, got {sorted(cells)}")
    seeds = [spec.seed for spec in specs]
    if len(set(seeds)) < len(seeds):
        raise ValueError(f"the seeds of a cohort are distinct, got {seeds}")
    return cells.pop()
