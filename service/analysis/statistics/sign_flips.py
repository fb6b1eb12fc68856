"""A permutation test of paired differences: is their mean other than 0?

If both members of a pair come from one distribution, its difference d_i is as likely as -d_i, and
each of the 2^n choices of signs is as likely as the observed one (Fisher, 1935):

    p = share of the choices s with |sum_i s_i d_i| >= |sum_i d_i|

The test assumes no distribution, and is exact up to 32 pairs. The sums of both halves of the pairs
are listed, and each of one half is looked up among those of the other. Of longer halves, 2^16
choices are drawn at random, the observed one among them.
"""

import numpy as np

from physics.randomness import generator
from service.analysis.curves import Floats

LISTED = 16
"""Pairs of which all choices of signs are listed."""
ROUNDING = 1e-12
"""Sums that differ by less, as a share of the largest, are equal."""


def sign_flip_p(d: Floats) -> float:
    """Return the two-sided p of differences d [n], all finite; 1 for none."""
    middle = len(d) // 2
    left, right = _sums(d[:middle], 0), np.sort(_sums(d[middle:], 1))
    least = abs(float(d.sum())) - ROUNDING * float(np.abs(d).sum())
    if least <= 0.0:
        return 1.0
    above = len(right) - np.searchsorted(right, least - left, side="left")
    below = np.searchsorted(right, -least - left, side="right")
    return float((above.sum() + below.sum()) / (len(left) * len(right)))


def _sums(d: Floats, half: int) -> Floats:
    """Return the sums of d [n] for the choices of its signs, that of all pluses first."""
    if len(d) > LISTED:
        return _drawn_signs(len(d), half) @ d
    sums = np.zeros(1)
    for value in d:
        sums = np.concatenate([sums + value, sums - value])
    return sums


def _drawn_signs(pairs: int, half: int) -> Floats:
    draws = generator(0, "sign flips", half)
    signs = draws.choice((-1.0, 1.0), size=(2**LISTED, pairs))
    signs[0] = 1.0
    return signs
