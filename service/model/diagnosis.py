"""The diagnosis of a run: its findings, or that they are still to be made.

    (none) -> waiting -> done | failed -> waiting, if it is requested again

The diagnosis of an earlier attempt of the run does not count.
"""

from dataclasses import dataclass

from algorithms.diagnostics.finding import Finding
from service.model.run import Run


@dataclass(frozen=True)
class Diagnosis:
    """The state of the diagnosis of a run.

    is_waiting  it was requested, and is not made yet
    findings    None while there are none
    problem     why there are none, a sentence; empty while nothing is wrong
    """

    run: Run
    is_waiting: bool = False
    findings: tuple[Finding, ...] | None = None
    problem: str = ""
