"""Holm's correction of several tests' p-values (Holm, 1979).

    p~_(k) = max over j <= k of min(1, (m - j + 1) p_(j))        p_(1) <= ... <= p_(m)

Rejecting where p~ <= 0.05 makes a false rejection in any of the m tests with a probability of at
most 5 %, however the tests depend on one another.
"""

from collections.abc import Sequence

import numpy as np

from service.analysis.curves import Floats


def holm(p: Sequence[float], tests: int) -> Floats:
    """Return the corrected p-values [k], of k of so many tests; the p of the others count as 1.

    Args:
        p: of the tests that have one.
        tests: m, all of them; at least k.
    """
    order = np.argsort(p, kind="stable")
    factors = tests - np.arange(len(order))
    corrected = np.empty(len(order))
    ascending = np.asarray(p, np.float64)[order]
    corrected[order] = np.maximum.accumulate(np.minimum(1.0, factors * ascending))
    return corrected
