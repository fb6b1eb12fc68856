"""The record of the gradient audit: its results, stored beside the code as `audit.json`."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from physics.catalogue import names

COUNT = 2_000
TOLERANCE = 1e-6
RECORD = Path(__file__).with_name("audit.json")


@dataclass(frozen=True, slots=True)
class RegimeAudit:
    """What the audit found in one regime of one task."""

    environment: str
    """Its label: the name, and the values of parameters that were given."""
    version: int
    regime: str
    states: int
    """How many states were compared."""
    kinks: int
    """How many further states lie at a kink."""
    worst: float
    """The worst relative error of the states compared."""
    median: float
    undeclared: int = 0
    """How many states have a kink nearby that the task's `pieces` does not declare."""

    def passed(self, count: int = COUNT, tolerance: float = TOLERANCE) -> bool:
        """Whether `count` states were compared and all their errors are within the tolerance.

        False if an error is NaN.
        """
        return self.states >= count and self.worst <= tolerance


def as_table(rows: Iterable[RegimeAudit]) -> str:
    """The audit as a Markdown table."""
    lines = [
        "| task | version | regime | states | at a kink | worst | median |",
        "|---|---|---|---:|---:|---:|---:|",
    ]
    lines += [
        f"| {row.environment} | {row.version} | {row.regime} | {row.states:,} | {row.kinks:,} "
        f"| {row.worst:.1e} | {row.median:.1e} |"
        for row in rows
    ]
    return "\n".join(lines) + "\n"


def write_record(rows: Sequence[RegimeAudit], path: Path = RECORD) -> None:
    """Store an audit for the documentation and the catalogue; rows of other tasks stay."""
    audited = {row.environment for row in rows}
    kept = [row for row in read_record(path) if row.environment not in audited]
    order = {name: place for place, name in enumerate(names())}
    together = sorted([*kept, *rows], key=lambda row: order.get(row.environment, len(order)))
    path.write_text(json.dumps([asdict(row) for row in together], indent=1) + "\n")


def read_record(path: Path = RECORD) -> list[RegimeAudit]:
    """The stored audit, one row for each regime of each task."""
    if not path.exists():
        return []
    return [RegimeAudit(**row) for row in json.loads(path.read_text())]


def audited(environment: str, version: int) -> list[RegimeAudit]:
    """The stored rows of this version of a task; none where it was never audited."""
    return [
        row for row in read_record() if (row.environment, row.version) == (environment, version)
    ]
