"""A robot's description becomes the constants that MuJoCo compiles from the same geometry."""

import numpy as np
import pytest

from physics.robots.model.description import Capsule
from physics.tasks.half_cheetah import ROBOT, HalfCheetah

MECHANISM = HalfCheetah.mechanism[0]


def test_a_long_thin_capsule_is_a_rod_and_a_short_one_a_ball() -> None:
    rod = Capsule("rod", (0.0, 0.0), 1.0, 0.0, 1e-4)
    assert rod.inertia(3.0) == pytest.approx(3.0 * 2.0**2 / 12, rel=1e-3)
    ball = Capsule("ball", (0.0, 0.0), 0.0, 0.0, 0.5)
    assert ball.inertia(3.0) == pytest.approx(0.4 * 3.0 * 0.5**2)
    assert ball.volume == pytest.approx(4 / 3 * np.pi * 0.5**3)


def test_the_end_along_the_axis_comes_first() -> None:
    ends = Capsule("c", (0.1, 0.2), 0.5, np.pi / 2, 0.1).ends
    np.testing.assert_allclose(ends, [(0.6, 0.2), (-0.4, 0.2)])


@pytest.mark.parametrize(
    ("link", "mass", "centre", "inertia"),
    [
        ("bshin", 2.68285, (-0.1849, -0.1382), 0.05054),
        ("fshin", 2.08536, (0.1117, -0.1579), 0.03095),
    ],
)
def test_a_shin_and_its_welded_foot(
    link: str, mass: float, centre: tuple[float, float], inertia: float
) -> None:
    """The composite bodies as they were worked out by hand (mass, centre, inertia about it)."""
    j = 2 + [each.name for each in ROBOT.links].index(link)
    moment = MECHANISM.moment[j]
    np.testing.assert_allclose(moment / mass, centre, atol=1e-4)
    assert MECHANISM.inertia[j] - moment @ moment / mass == pytest.approx(inertia, abs=1e-5)


def test_torso_and_head_are_what_is_left() -> None:
    """Root's moments less those of the legs, which count as masses at the hips.

    The inertia is the largest of MuJoCo's three principal ones: y is the axis across.
    """
    names = [each.name for each in ROBOT.links]
    legs = {"bthigh": 1.54351 + 2.68285, "fthigh": 1.43808 + 2.08536}
    mass = 14.0 - sum(legs.values())
    assert mass == pytest.approx(6.25021, abs=1e-4)
    hips = {name: MECHANISM.arm[2 + names.index(name)] for name in legs}
    moment = MECHANISM.moment[2] - sum(legs[name] * hips[name] for name in legs)
    np.testing.assert_allclose(moment / mass, (0.1524, 0.0254), atol=1e-4)
    about_root = MECHANISM.inertia[2] - sum(legs[name] * hips[name] @ hips[name] for name in legs)
    assert about_root - moment @ moment / mass == pytest.approx(0.897118, abs=1e-4)


def test_a_mechanism_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        MECHANISM["gear"][3] = 1.0
