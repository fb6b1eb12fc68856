"""The confidence sequence of a mean: the values that have not been refuted, look by look.

    lower_l = max over looks k <= l of sup {m : log E_n_k(m) >= log(1/a)}      upper: of -d

Each side misses the mean at any of the looks with probability at most a (`evidence`). The evidence
decreases in m, so that the supremum is found by bisection.
"""

from dataclasses import dataclass

import numpy as np

from service.analysis.curves import Floats
from service.analysis.question.evidence import log_evidence
from service.model.inquiry.question import Method

HALVINGS = 20
"""The bounds are known to within 2 clip / 2^20."""


@dataclass(frozen=True)
class ConfidenceSequence:
    """Bounds at each look.

    n     pairs seen by then [looks]
    mean  of the differences [looks]; NaN before the first pair
    low   [looks]
    high  [looks]
    """

    n: tuple[int, ...]
    mean: Floats
    low: Floats
    high: Floats


def confidence_sequence(
    differences: Floats, n: tuple[int, ...], level: float, method: Method, clip: float
) -> ConfidenceSequence:
    """Return the sequence of differences [k] at looks after n of them, `level` on either side."""
    bounds = [
        (
            _lower(differences[:seen], level, method, clip),
            -_lower(-differences[:seen], level, method, clip),
        )
        for seen in n
    ]
    low, high = np.array(bounds).reshape(-1, 2).T
    means = [float(differences[:seen].mean()) if seen else np.nan for seen in n]
    return ConfidenceSequence(
        n, np.array(means), np.maximum.accumulate(low), np.minimum.accumulate(high)
    )


def _lower(d: Floats, level: float, method: Method, clip: float) -> float:
    """Return the largest value that differences [n] refute; -clip where they refute none."""
    if not len(d):
        return -clip
    refuted, open_ = -clip, clip
    for _ in range(HALVINGS):
        middle = (refuted + open_) / 2
        if log_evidence(d, middle, (len(d),), method, clip) >= -np.log(level):
            refuted = middle
        else:
            open_ = middle
    return refuted
