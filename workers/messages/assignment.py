"""An assignment: a run to train, under a name and the number of the attempt."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from workers.messages.run_spec import RunSpec


@dataclass(frozen=True)
class Assignment:
    """A run under one attempt, as the service claims it and its worker trains it.

    run_id               the name of its checkpoints
    attempt              reports of the worker under an older number are refused
    environment_version  of its task's numbers, under which it was submitted
    """

    run_id: str
    attempt: int
    spec: RunSpec
    environment_version: int

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal assignment back."""
        return {**vars(self), "spec": self.spec.to_json()}

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Assignment":
        """Read what `to_json` wrote."""
        return cls(**{**document, "spec": RunSpec.from_json(document["spec"])})
