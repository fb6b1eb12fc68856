"""The gradient audit: how far every derivative is from central differences, regime by regime.

For each regime of a task, states are drawn until at least `count` of them have differences to be
held against. A state has none where it lies at a kink: there, every difference wider than rounding
allows has its points on different smooth pieces of the map, as the task's own `pieces` tells.
Such states are counted, not compared. For each of the others the error is

    max |exact - difference| / max |exact|

over the state Jacobian, the action Jacobian and the reward's total gradients, each by itself (see
`differences`), and the audit reports the worst.
"""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from physics.catalogue import names
from physics.differences import differences, relative_errors
from physics.environment import Environment
from physics.randomness import generator

COUNT = 2_000
TOLERANCE = 1e-6
RECORD = Path(__file__).with_name("audit.json")

_CHUNK = 500
# A regime so rare that this many chunks do not fill it is reported with what was found.
_MOST_CHUNKS = 400


@dataclass(frozen=True, slots=True)
class RegimeAudit:
    """What the audit found in one regime of one task."""

    environment: str
    version: int
    regime: str
    states: int
    """How many states were compared."""
    kinks: int
    """How many more were drawn that lie at a kink."""
    worst: float
    """The worst relative error of the states compared."""
    median: float

    def passed(self, count: int = COUNT) -> bool:
        """Whether `count` states were compared and all their errors are within the tolerance."""
        return self.states >= count and self.worst <= TOLERANCE


def audit(environment: Environment, count: int = COUNT, seed: int = 0) -> list[RegimeAudit]:
    """Audit every regime of a task over at least `count` smooth states each."""
    regimes = range(len(environment.regimes))
    errors: dict[int, list[float]] = {regime: [] for regime in regimes}
    kinks = dict.fromkeys(regimes, 0)
    for index in range(_MOST_CHUNKS):
        wanted = [regime for regime in regimes if len(errors[regime]) < count]
        if not wanted:
            break
        states, actions = environment.sample(generator(seed, "audit", index), _CHUNK)
        regime_of = environment.pieces(states, actions).regime
        rows = np.isin(regime_of, wanted)
        states, actions, regime_of = states[rows], actions[rows], regime_of[rows]
        reference = differences(environment, states, actions)
        row_errors = relative_errors(environment.differentiate(states, actions), reference)
        for regime in wanted:
            here = regime_of == regime
            errors[regime] += row_errors[here & reference.smooth].tolist()
            kinks[regime] += int((here & ~reference.smooth).sum())
    return [
        RegimeAudit(
            environment.name,
            environment.version,
            environment.regimes[regime],
            len(errors[regime]),
            kinks[regime],
            max(errors[regime], default=float("inf")),
            float(np.median(errors[regime])) if errors[regime] else float("inf"),
        )
        for regime in regimes
    ]


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
    """Keep an audit, for the documentation and the catalogue; other tasks' rows stay."""
    audited = {row.environment for row in rows}
    kept = [row for row in read_record(path) if row.environment not in audited]
    order = {name: place for place, name in enumerate(names())}
    together = sorted([*kept, *rows], key=lambda row: order.get(row.environment, len(order)))
    path.write_text(json.dumps([asdict(row) for row in together], indent=1) + "\n")


def read_record(path: Path = RECORD) -> list[RegimeAudit]:
    """The audit as it was kept, one row for each regime of each task."""
    if not path.exists():
        return []
    return [RegimeAudit(**row) for row in json.loads(path.read_text())]
