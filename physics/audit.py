"""The gradient audit: how far every derivative is from central differences, regime by regime.

For each regime of a task, states are drawn until at least `count` of them have differences to be
held against. A state has none where it lies at a kink: there, every difference wider than rounding
allows has its points on different smooth pieces of the map, as the task's own `pieces` tells.
Such states are counted, not compared. For each of the others the error is

    max |exact - difference| / max |exact|

over the state Jacobian, the action Jacobian and the reward's total gradients, each by itself (see
`differences`), and the audit reports the worst.
"""

import numpy as np

from physics.audit_record import COUNT, RegimeAudit
from physics.differences import differences, relative_errors
from physics.environment import Environment
from physics.randomness import generator

_CHUNK = 500
# A regime so rare that this many chunks do not fill it is reported with what was found.
_MOST_CHUNKS = 400


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
