"""The first touch of a flying body: none missed, none invented, ties by index."""

import math

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.impacts.die_motion import CORNERS, GRAVITY, REACH
from physics.impacts.first_touch import NO_TOUCH, first_touch
from physics.impacts.flying_body import FlyingBody
from physics.randomness import generator

TIME = 0.02


def paths(body: FlyingBody, alpha: float, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gap and rate [times, corner] of a flying body."""
    angle = body.angle + body.spin * times + alpha * times**2 / 2
    angles = angle[:, None] + np.pi / 4 + np.pi / 2 * np.arange(4)
    height = body.y + body.vy * times - GRAVITY * times**2 / 2
    spin = (body.spin + alpha * times)[:, None]
    gap = height[:, None] + REACH * np.sin(angles)
    return gap, (body.vy - GRAVITY * times)[:, None] + spin * REACH * np.cos(angles)


def touch(body: FlyingBody, alpha: float = 0.0) -> tuple[int, float]:
    return first_touch(body, CORNERS, REACH, GRAVITY, alpha)


def check(body: FlyingBody, alpha: float) -> bool:
    """Hold the touch found against a dense sampling; whether there was one."""
    corner, moment = touch(body, alpha)
    times = np.linspace(0.0, moment, 400)
    gap, rate = paths(body, alpha, times)
    assert not ((gap[:-1] < -1e-12) & (rate[:-1] < 0)).any()
    if corner == NO_TOUCH:
        assert moment == body.time
        return False
    assert abs(gap[-1, corner]) < 1e-13
    assert rate[-1, corner] < 1e-9
    return True


def test_every_touch_is_found_when_it_happens() -> None:
    random = generator(0, "touches")
    found = 0
    for _ in range(3000):
        angle, spin = random.uniform(-7, 7), random.uniform(-13, 13)
        lowest = REACH * np.sin(angle + np.pi / 4 + np.pi / 2 * np.arange(4)).min()
        y = -lowest + random.uniform(0, 0.05)
        body = FlyingBody(0.0, y, angle, 0.0, random.uniform(-3, 1), spin, TIME)
        found += check(body, random.uniform(-6, 6))
    assert 1000 < found < 2500


def test_no_dip_is_too_brief() -> None:
    """Corners that swing through their lowest point within the step, a hair above or below 0."""
    random = generator(0, "dips")
    dips = 0
    for _ in range(2000):
        spin, alpha = random.choice([-1, 1]) * random.uniform(5, 13), random.uniform(-6, 6)
        body = FlyingBody(0.0, 0.0, np.pi / 4 + random.uniform(-0.1, 0.1), 0.0, 0.0, spin, TIME)
        body = body._replace(vy=random.uniform(-0.3, 0.3))
        times = np.linspace(0, TIME, 2001)
        gaps = paths(body, alpha, times)[0].min(axis=1)
        bottom = int(gaps.argmin())
        if not 100 < bottom < 1900:
            continue  # it does not swing through
        # A parabola through three samples gives the depth to some 1e-13 m.
        left, middle, right = gaps[bottom - 1 : bottom + 2]
        lowest = middle - (right - left) ** 2 / (8 * (left - 2 * middle + right))
        for depth in 10.0 ** random.uniform(-11, -6, 2):
            dips += 1
            assert touch(body._replace(y=-lowest - depth), alpha)[0] != NO_TOUCH
            assert check(body._replace(y=-lowest - depth), alpha)
            assert touch(body._replace(y=-lowest + depth), alpha) == (NO_TOUCH, TIME)
    assert dips > 500


@pytest.mark.parametrize("quarter", range(-2, 3))
def test_of_two_corners_at_the_same_moment_the_smaller_index_comes_first(quarter: int) -> None:
    body = FlyingBody(0.0, 0.505, quarter * np.pi / 2, 1.0, -1.0, 0.0, TIME)
    corner, moment = touch(body)
    assert corner == {0: 2, 1: 1, -1: 0, 2: 0, -2: 0}[quarter] == min(lower_pair(quarter))
    assert moment == pytest.approx((math.sqrt(1 + 2 * GRAVITY * 0.005) - 1) / GRAVITY, rel=1e-12)
    later = body._replace(spin=1e-9 if corner == min(lower_pair(quarter)) else -1e-9)
    assert touch(later)[0] in lower_pair(quarter)


def lower_pair(quarter: int) -> set[int]:
    """The two corners on the ground of a die that lies flat."""
    return {(2 - quarter) % 4, (3 - quarter) % 4}


def test_on_the_ground_only_an_approach_is_a_touch() -> None:
    standing = FlyingBody(0.0, REACH, np.pi / 4, 0.0, 0.0, 0.0, TIME)
    assert touch(standing._replace(y=0.7, vy=-1.0)) == (2, 0.0)
    assert touch(standing._replace(y=REACH + 1e-16, vy=1.0)) == (NO_TOUCH, TIME)
    corner, moment = touch(standing._replace(vy=0.05))
    assert corner == 2
    assert moment == pytest.approx(2 * 0.05 / GRAVITY, rel=1e-9)


def test_a_search_without_end_is_no_answer() -> None:
    corner, moment = touch(FlyingBody(0.0, 0.7072, 0.0, 0.0, 0.0, 1e9, TIME))
    assert corner == NO_TOUCH
    assert math.isnan(moment)
