"""The gradient audit: how far every derivative is from central differences, regime by regime.

For each regime of a task, states are drawn until at least `count` of them can be compared with
differences. A state at a kink cannot: there, every difference that is wide enough for rounding has
its points on different smooth pieces of the map, according to the task's own `pieces`. Such states
are counted, not compared. For each of the others the error is

    max |exact - difference| / max |exact|

computed separately for the state Jacobian, the action Jacobian and the reward's total gradients
(see `differences`), and the audit reports the worst. A state whose step or derivatives are not
finite has an infinite error.

Differences also reveal kinks that `pieces` does not declare: those states are counted as well.
"""

from typing import NamedTuple

import numpy as np

from physics.audit.differences import differences, relative_errors
from physics.audit.record import COUNT, RegimeAudit
from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    IntArray,
    Linearization,
    NotFiniteError,
)
from physics.randomness import generator

_CHUNK = 500
# A regime so rare that this many chunks do not fill it is reported with what was found.
_MOST_CHUNKS = 400


class Findings(NamedTuple):
    """The results of some rows of one regime."""

    errors: FloatArray
    """The errors of the states compared; infinite where the derivatives are not finite."""
    kinks: int
    undeclared: int


def audit(environment: Environment, count: int = COUNT, seed: int = 0) -> list[RegimeAudit]:
    """Audit every regime of a task over at least `count` smooth states each."""
    regimes = range(len(environment.regimes))
    found: dict[int, list[Findings]] = {regime: [] for regime in regimes}
    for index in range(_MOST_CHUNKS):
        wanted = [regime for regime in regimes if _compared(found[regime]) < count]
        if not wanted:
            break
        states, actions = environment.sample(generator(seed, "audit", index), _CHUNK)
        regime_of = environment.pieces(states, actions).regime
        rows = np.isin(regime_of, wanted) & (_ranks(regime_of) < count)
        states, actions, regime_of = states[rows], actions[rows], regime_of[rows]
        errors, bent = _examine(environment, states, actions)
        for regime in wanted:
            here = regime_of == regime
            compared = here & ~np.isnan(errors)
            kinks, undeclared = int((here & ~compared).sum()), int((here & bent).sum())
            found[regime].append(Findings(errors[compared], kinks, undeclared))
    return [_report(environment, regime, found[regime]) for regime in regimes]


def _ranks(regime_of: IntArray) -> IntArray:
    """For each row, how many earlier rows are of the same regime [batch]."""
    ranks: IntArray = np.tril(regime_of[:, None] == regime_of[None], -1).sum(axis=1)
    return ranks


def _compared(findings: list[Findings]) -> int:
    return sum(len(each.errors) for each in findings)


def _report(environment: Environment, regime: int, findings: list[Findings]) -> RegimeAudit:
    errors = np.concatenate([np.empty(0), *(each.errors for each in findings)])
    return RegimeAudit(
        environment.label,
        environment.version,
        environment.regimes[regime],
        len(errors),
        sum(each.kinks for each in findings),
        float(errors.max()) if errors.size else float("inf"),
        float(np.median(errors)) if errors.size else float("inf"),
        sum(each.undeclared for each in findings),
    )


def _examine(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """The error of each row [batch], NaN at a kink, and which rows have an undeclared kink.

    The error is infinite where derivatives are not finite, even at a kink.
    """
    errors, bent = np.full(len(states), np.inf), np.zeros(len(states), np.bool_)
    linearization, finite = _finite_part(environment, states, actions)
    found = differences(environment, states[finite], actions[finite])
    compared = relative_errors(linearization, found)
    errors[finite], bent[finite] = (
        np.where(found.smooth | np.isinf(compared), compared, np.nan),
        found.bent,
    )
    return errors, bent


def _finite_part(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> tuple[Linearization, BoolArray]:
    """The derivatives of the rows where they are finite, and which rows these are."""
    finite = np.ones(len(states), np.bool_)
    try:
        transition, *derivatives = environment.differentiate(states, actions)
    except NotFiniteError as error:
        finite[list(error.rows)] = False
        transition, *derivatives = environment.differentiate(states[finite], actions[finite])
    return Linearization(transition, *derivatives), finite
