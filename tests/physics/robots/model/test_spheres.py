"""Which spheres can touch the ground."""

from physics.robots.model.spheres import end_spheres, touching
from physics.tasks.half_cheetah import ROBOT as CHEETAH
from physics.tasks.hopper import ROBOT as HOPPER
from physics.tasks.walker2d import ROBOT as WALKER


def test_those_around_a_joint_inside_the_neighbour_cannot() -> None:
    """The thigh begins where the torso ends; the leg is thinner than thigh and foot."""
    assert [sphere.capsule.name for sphere in touching(HOPPER)] == [
        "torso",
        "torso",
        "thigh",
        "foot",
        "foot",
    ]
    assert len(end_spheres(HOPPER)) == 8
    assert len(touching(WALKER)) == 8


def test_those_beside_a_joint_can() -> None:
    assert touching(CHEETAH) == end_spheres(CHEETAH)
    assert len(touching(CHEETAH)) == 16
