"""The first touch of a flying body's corners with the ground, by conservative advancement.

    gap(t + s) >= gap(t) + v(t) s - M s^2 / 2,      M = g + |alpha| reach + omega_max^2 reach

holds for every corner, because its gap'' is -g + alpha rx - omega^2 ry. The corner stays clear of
the ground until the root of the right side, so the search advances to that root and repeats: it
cannot miss a dip, however brief, and near a touch it converges as Newton's method does, from the
safe side.

Glossary: gap height of a corner (m); v its rate (m/s); (rx, ry) the corner seen from the centre, at
most `reach` away; g gravity; alpha angular acceleration; omega_max the largest turning rate.
Source: Mirtich, "Impulse-based dynamic simulation of rigid body systems", thesis, Berkeley, 1996.
"""

import math

import numpy as np
from numpy.typing import NDArray

from physics.impacts.flying_body import FlyingBody, fly
from physics.kernels.compiled import compiled

SAME_MOMENT = 1e-12  # s: touches closer than this count as one
ARRIVED = 1e-14  # s: the search is at the moment, up to rounding
MAX_ADVANCES = 10_000  # near grazing dips some 70 were seen
NO_TOUCH = -1

Corners = NDArray[np.float64]


@compiled
def first_touch(
    body: FlyingBody, corners: Corners, reach: float, gravity: float, alpha: float
) -> tuple[int, float]:
    """The first corner with gap <= 0 and v < 0 in the time left, and the time until then (s).

    Moments closer than SAME_MOMENT count as equal; the smallest index then comes first. Corners are
    `[n, 2]`, seen from the centre at angle 0. Returns NO_TOUCH and the time left if none touches,
    and NO_TOUCH and NaN if the search does not end (a die that turns a thousand times a step).
    """
    time_left = body.time
    if min(body.y, fly(body, None, time_left, gravity, alpha).y) > reach:
        return NO_TOUCH, time_left  # y is concave in time: lowest at an end
    fastest = max(abs(body.spin), abs(body.spin + alpha * time_left))
    M = gravity + (abs(alpha) + fastest * fastest) * reach
    moment = 0.0
    for _ in range(MAX_ADVANCES):
        at = fly(body, None, moment, gravity, alpha)
        cosine, sine = math.cos(at.angle), math.sin(at.angle)
        touching, closing, after, clear = NO_TOUCH, 0.0, math.inf, math.inf
        for corner in range(len(corners)):
            rx = cosine * corners[corner, 0] - sine * corners[corner, 1]
            ry = sine * corners[corner, 0] + cosine * corners[corner, 1]
            gap, rate = at.y + ry, at.vy + at.spin * rx
            if gap > 0.0 and gap + at.time * (rate - 0.5 * M * at.time) > 0.0:
                continue  # clear to the end, because the bound is concave in time
            corner_clear = _clear_time(gap, rate, M)
            clear = min(clear, corner_clear)
            if rate < 0.0 and corner_clear < after - SAME_MOMENT:
                touching, closing, after = corner, -rate, corner_clear
        if after <= clear + SAME_MOMENT and 0.5 * M * after * after <= ARRIVED * closing:
            # The bound and the gap differ from here by no more than rounding.
            return touching, min(moment + after, time_left)
        moment += max(clear, ARRIVED)
        if moment > time_left:
            return NO_TOUCH, time_left
    return NO_TOUCH, math.nan


@compiled
def _clear_time(gap: float, rate: float, M: float) -> float:
    """First root `s >= 0` of gap + rate s - M s^2 / 2, or the moment of its vertex if gap < 0."""
    if gap <= 0.0 and rate < 0.0:
        return 0.0
    root = math.sqrt(max(0.0, rate * rate + 2.0 * M * gap))
    return (rate + root) / M if rate >= 0.0 else 2.0 * gap / (root - rate)
