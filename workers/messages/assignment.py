"""An assignment: a run to be trained, under a name and the number of the attempt."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from workers.messages.run_spec import RunSpec


@dataclass(frozen=True)
class Assignment:
    """What a worker is told of a run. Its checkpoints lie under its name."""

    run_id: str
    attempt: int
    spec: RunSpec

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal assignment back."""
        return {"run_id": self.run_id, "attempt": self.attempt, "spec": self.spec.to_json()}

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Assignment":
        """Read what `to_json` wrote."""
        return cls(document["run_id"], document["attempt"], RunSpec.from_json(document["spec"]))
