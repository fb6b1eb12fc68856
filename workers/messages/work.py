"""What a worker is given to do."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from workers.messages.assignment import Assignment
from workers.messages.run_spec import RunSpec

REPORT_SECONDS = 1.0


@dataclass(frozen=True)
class Work:
    """A cohort to train.

    cohort                names it in every report; never given twice
    runs                  its runs
    measure_random_return measure that of its task first
    note                  plain values, for whoever hears of the cohort and did not assign it
    report_seconds        between two reports of its progress; each is also a heartbeat
    """

    cohort: str
    runs: tuple[Assignment, ...]
    measure_random_return: bool = False
    note: Mapping[str, Any] = field(default_factory=dict)
    report_seconds: float = REPORT_SECONDS

    @property
    def specs(self) -> tuple[RunSpec, ...]:
        """The runs' specs."""
        return tuple(run.spec for run in self.runs)

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal one back."""
        return {
            "cohort": self.cohort,
            "runs": [run.to_json() for run in self.runs],
            "measure_random_return": self.measure_random_return,
            "note": dict(self.note),
            "report_seconds": self.report_seconds,
        }

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Work":
        """Read what `to_json` wrote."""
        return cls(
            document["cohort"],
            tuple(Assignment.from_json(run) for run in document["runs"]),
            document["measure_random_return"],
            document["note"],
            document["report_seconds"],
        )
