"""What a worker is given to do."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from workers.run_spec import RunSpec


@dataclass(frozen=True)
class Work:
    """A cohort to train.

    cohort                names it in every report; never given twice
    specs                 its runs
    measure_random_return measure that of its task first
    note                  plain values, for whoever hears of the cohort and did not assign it
    """

    cohort: str
    specs: tuple[RunSpec, ...]
    measure_random_return: bool = False
    note: Mapping[str, Any] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal one back."""
        return {
            "cohort": self.cohort,
            "specs": [spec.to_json() for spec in self.specs],
            "measure_random_return": self.measure_random_return,
            "note": dict(self.note),
        }

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Work":
        """Read what `to_json` wrote."""
        return cls(
            document["cohort"],
            tuple(RunSpec.from_json(spec) for spec in document["specs"]),
            document["measure_random_return"],
            document["note"],
        )
