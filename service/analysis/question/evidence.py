"""Evidence that the mean of paired differences is above a value, at any time.

The evidence E_n against "the mean is at most m" is a nonnegative process that starts at 1 and does
not grow on average where that is true. By Ville's inequality it ever reaches 1/a with probability
at most a, however often and for whatever reason one looks at it; 1 / max_n E_n is a p-value at any
time. Evidence below a value is that of the negated differences above the negated value.

"bounded": differences d_i in [-c, c], and nothing else is assumed. A bet that the mean is above m,
on which one stakes a share f of what one has (Waudby-Smith and Ramdas, JRSS B 86, 2024: the hedged
capital process, sections 4.1 and 4.2, with constant shares mixed as in its grid-Kelly bets):

    E_n(m) = sum_j p_j prod_{i <= n} (1 + f_j (d_i - m) / (m + c))      every factor >= 1 - f_j > 0

E_n(m) decreases in m, so that the values which are not refuted form an interval.

"normal": differences independent and normally distributed, of any variance. The t-statistic's
likelihood ratio, mixed over effects mu / sigma ~ N(0, 1/g) (Wang and Ramdas, "Anytime-valid
t-tests and confidence sequences for Gaussian means with unknown variance", 2025, section 4):

    E_n(m) = sqrt(g / (n + g)) (V / (V - S^2 / (n + g)))^(n/2)

with S = sum (d_i - m) and V = sum (d_i - m)^2, where S > 0; else 0. Where differences are not
normal this is an approximation, and a bad one where few seeds fail badly: see docs/questions.md.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from service.analysis.curves import Floats
from service.model.inquiry.question import Method

SHARES = (0.1, 0.5, 0.9)
"""f: of the largest stake that cannot lose more than there is."""
LOG_WEIGHTS = tuple(np.log([0.25, 0.25, 0.5]))
"""log p."""
EFFECT_PRECISION = 4.0
"""g: effects of half a standard deviation are expected."""


def log_evidence(
    differences: Floats, value: float, n: Sequence[int], method: Method, clip: float
) -> Floats:
    """Return log E_n that the mean of differences is above a value, at some n.

    Args:
        differences: in [-clip, clip], [..., k].
        value: m, above -clip.
        n: looks: how many of the differences were seen; 0 is before the first one.
        method: how.
        clip: c.

    Returns:
        [..., looks].
    """
    evidence = np.zeros((*differences.shape[:-1], len(n)))
    seen = np.array(n, np.int64)
    begun = seen > 0
    find = _bounded if method == "bounded" else _normal
    evidence[..., begun] = find(differences, value, seen[begun], clip)
    return evidence


def _bounded(d: Floats, m: float, n: NDArray[np.int64], clip: float) -> Floats:
    gains = (d - m) / (m + clip)
    logs = [
        log_weight + np.cumsum(np.log1p(share * gains), axis=-1)[..., n - 1]
        for share, log_weight in zip(SHARES, LOG_WEIGHTS, strict=True)
    ]
    total: Floats = np.logaddexp.reduce(logs)
    return total


def _normal(d: Floats, m: float, n: NDArray[np.int64], _: float) -> Floats:
    total = np.cumsum(d - m, axis=-1)[..., n - 1]
    squares = np.cumsum((d - m) ** 2, axis=-1)[..., n - 1]
    left = squares - total**2 / (n + EFFECT_PRECISION)  # > 0 unless all are m
    ratio = np.divide(squares, left, out=np.ones_like(left), where=left > 0)
    found = 0.5 * np.log(EFFECT_PRECISION / (n + EFFECT_PRECISION)) + n / 2 * np.log(ratio)
    return np.where(total > 0, found, -np.inf)
