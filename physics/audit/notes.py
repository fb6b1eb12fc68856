"""Audit notes: what an audit's numbers do not show: undeclared kinks, and what was not sampled."""

from collections.abc import Iterator, Sequence

import numpy as np

from physics.audit.record import TOLERANCE, RegimeAudit
from physics.environment import Environment, FloatArray, Pieces
from physics.randomness import generator

SHOWN = 1_000
"""How many states the notes are about."""


def failures(rows: Sequence[RegimeAudit], count: int, tolerance: float = TOLERANCE) -> list[str]:
    """For each regime that did not pass, a line with the reason."""
    return [
        f"NOT PASSED: {row.environment}, {row.regime}: {_reason(row, count, tolerance)}"
        for row in rows
        if not row.passed(count, tolerance)
    ]


def _reason(row: RegimeAudit, count: int, tolerance: float) -> str:
    if row.states + row.kinks == 0:
        return "never sampled; let the task's `sample` go there"
    if not np.isfinite(row.worst) and row.states:
        return "a step, a derivative or a difference is NaN or infinite"
    if row.worst > tolerance and row.states:
        return f"the worst error is {row.worst:.1e}, which is above {tolerance:.0e}"
    return (
        f"{row.states:,} of {count:,} states compared, {row.kinks:,} more lie at a kink; "
        "let the task's `sample` go there more often"
    )


def notes(environment: Environment, rows: Sequence[RegimeAudit]) -> list[str]:
    """The notes that accompany the table, from a sample of states."""
    states, actions = environment.sample(generator(0, "audit", 0), SHOWN)
    pieces = environment.pieces(states, actions)
    return [
        *_undeclared(environment, sum(row.undeclared for row in rows)),
        *_unsampled(environment, pieces),
        *_unknown(environment, states),
        *(f"NOTE: {environment.label}: {each}" for each in environment.remarks(states, actions)),
    ]


def _undeclared(environment: Environment, count: int) -> Iterator[str]:
    if count:
        yield (
            f"NOTE: {environment.label}: {count:,} states have a kink nearby that `pieces` does "
            "not declare: there, wide differences disagree with narrow ones."
        )


def _unsampled(environment: Environment, pieces: Pieces) -> Iterator[str]:
    """Lines on pieces that no state shows, and on regimes that the task does not declare."""
    names = len(environment.regimes)
    nameless = sorted(set(pieces.regime.tolist()) - set(range(names)))
    if nameless:
        yield (
            f"NOT PASSED: {environment.label}: `pieces` returns the regimes {nameless}, but "
            f"`regimes` has names for 0 to {names - 1}"
        )
    constant = np.flatnonzero((pieces.piece == pieces.piece[:1]).all(axis=0)).tolist()
    if constant:
        yield (
            f"NOTE: {environment.label}: over {SHOWN:,} states the columns {constant} of `pieces` "
            "never changed: the kinks that they declare were not sampled."
        )


def _unknown(environment: Environment, states: FloatArray) -> Iterator[str]:
    """The range of each coordinate, where the task declares no kink."""
    if type(environment).pieces is Environment.pieces:
        limits = enumerate(zip(states.min(axis=0), states.max(axis=0), strict=True))
        ranges = ", ".join(f"from {low:.3g} to {high:.3g} in s[{i}]" for i, (low, high) in limits)
        yield (
            f"NOTE: {environment.label} declares no kink but the clip of its actions. Whether "
            f"there are others that no state came near cannot be known. The states went {ranges}."
        )
