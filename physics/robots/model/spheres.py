"""Spheres: the ends of a robot's capsules, with which it touches the ground."""

from math import dist
from typing import NamedTuple

from physics.robots.model.description import SAME_PLACE, Capsule, Link, Robot, Vector


class Sphere(NamedTuple):
    """One end of a capsule."""

    link: int
    """Degree of freedom of its link."""
    centre: Vector
    capsule: Capsule


def end_spheres(robot: Robot) -> list[Sphere]:
    """All ends of all capsules, in the order of links and capsules, the one along +axis first."""
    return [
        Sphere(2 + k, end, capsule)
        for k, link in enumerate(robot.links)
        for capsule in link.capsules
        for end in capsule.ends
    ]


def touching(robot: Robot) -> list[Sphere]:
    """The end spheres that can touch the ground.

    A sphere around a joint, inside a capsule of the link across the joint, cannot touch first: that
    capsule reaches as low in any pose. Where two links end in the same sphere, only the parent's is
    kept. The omitted spheres would only make impulses ambiguous.
    """
    return [sphere for sphere in end_spheres(robot) if not _is_covered(robot, sphere)]


def _is_covered(robot: Robot, sphere: Sphere) -> bool:
    """Whether a capsule across a joint contains the sphere in any pose."""
    here = robot.links[sphere.link - 2]
    room = [
        _room(there, (0.0, 0.0), sphere) - SAME_PLACE
        for there in robot.links
        if there.parent == here.name and dist(sphere.centre, there.place) < SAME_PLACE
    ] + [
        _room(there, here.place, sphere) + SAME_PLACE
        for there in robot.links
        if there.name == here.parent and dist(sphere.centre, (0.0, 0.0)) < SAME_PLACE
    ]
    return max(room, default=-1.0) > 0.0


def _room(link: Link, point: Vector, sphere: Sphere) -> float:
    """The depth inside a link's capsules of the sphere, if at a point of the link's frame (m)."""
    return max(
        capsule.radius - sphere.capsule.radius - capsule.distance(point)
        for capsule in link.capsules
    )
