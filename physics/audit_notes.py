"""Audit notes: what an audit's numbers do not say: which kinks it met, and what it cannot know."""

from collections.abc import Sequence

import numpy as np

from physics.audit_record import TOLERANCE, RegimeAudit
from physics.environment import Environment
from physics.randomness import generator

SHOWN = 1_000
"""Of so many states the ranges are told."""


def failures(rows: Sequence[RegimeAudit], count: int) -> list[str]:
    """Why each regime that did not pass did not."""
    return [
        f"NOT PASSED: {row.environment}, {row.regime}: {_reason(row, count)}"
        for row in rows
        if not row.passed(count)
    ]


def _reason(row: RegimeAudit, count: int) -> str:
    if row.states + row.kinks == 0:
        return "never sampled; let the task's `sample` go there"
    if not np.isfinite(row.worst) and row.states:
        return "a step, a derivative or a difference is NaN or infinite"
    if row.worst > TOLERANCE and row.states:
        return f"the worst error is {row.worst:.1e}, which is above {TOLERANCE:.0e}"
    return (
        f"{row.states:,} of {count:,} states compared, {row.kinks:,} more lie at a kink; "
        "let the task's `sample` go there more often"
    )


def notes(environment: Environment, rows: Sequence[RegimeAudit]) -> list[str]:
    """What to know beside the table."""
    name, undeclared, found = environment.name, sum(row.undeclared for row in rows), []
    if undeclared:
        found.append(
            f"NOTE: {name}: {undeclared:,} states have a kink nearby that `pieces` does not "
            "declare: there, wide differences disagree with narrow ones."
        )
    if type(environment).pieces is Environment.pieces:
        found.append(
            f"NOTE: {name} declares no kink but the clip of its actions. Whether there are others "
            f"that no state came near cannot be known. The states went {_ranges(environment)}."
        )
    return found


def _ranges(environment: Environment) -> str:
    """How far the states of a sample go, coordinate by coordinate."""
    states, _ = environment.sample(generator(0, "audit", 0), SHOWN)
    limits = zip(states.min(axis=0), states.max(axis=0), strict=True)
    return ", ".join(
        f"from {low:.3g} to {high:.3g} in s[{i}]" for i, (low, high) in enumerate(limits)
    )
