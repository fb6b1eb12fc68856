"""The diagnosis of a run: what was found about it, or is to be.

    (none) -> waiting -> done | failed -> waiting, where it is asked for again

One that was made of an earlier attempt of the run is none.
"""

from dataclasses import dataclass

from algorithms.diagnostics.finding import Finding
from service.model.run import Run


@dataclass(frozen=True)
class Diagnosis:
    """Where the diagnosis of a run stands.

    is_waiting  it was asked for, and is to be made
    findings    None while there are none
    problem     why there are none, a sentence; empty while nothing is wrong
    """

    run: Run
    is_waiting: bool = False
    findings: tuple[Finding, ...] | None = None
    problem: str = ""
