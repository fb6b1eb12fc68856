"""The work of a worker."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from physics.task_file import TaskFile
from workers.messages.assignment import Assignment
from workers.messages.run_spec import RunSpec

REPORT_SECONDS = 1.0
LEASE_SECONDS = 15.0


@dataclass(frozen=True)
class Work:
    """A cohort to train.

    cohort                names it in every report; never given twice
    runs                  its runs
    lease_seconds         a worker that is silent for so long has lost them
    measure_random_return measure that of its task first
    report_seconds        between two reports of its progress; each is also a heartbeat
    file                  the text of its task, where the task is of a file
    """

    cohort: str
    runs: tuple[Assignment, ...]
    lease_seconds: float = LEASE_SECONDS
    measure_random_return: bool = False
    report_seconds: float = REPORT_SECONDS
    file: TaskFile | None = None

    @property
    def specs(self) -> tuple[RunSpec, ...]:
        """The runs' specs."""
        return tuple(run.spec for run in self.runs)

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal one back."""
        file = self.file and vars(self.file)
        return {**vars(self), "runs": [run.to_json() for run in self.runs], "file": file}

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Work":
        """Read what `to_json` wrote."""
        runs = tuple(Assignment.from_json(run) for run in document["runs"])
        file = document["file"] and TaskFile(**document["file"])
        return cls(**{**document, "runs": runs, "file": file})
