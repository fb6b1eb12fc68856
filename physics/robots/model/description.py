"""A planar robot as data: links in a tree, with their capsules, joints and motors.

Frames: x forward, z up; a link turned by `theta` carries its own vector `p` to the world as
`R(theta) p` with `R = [[cos, sin], [-sin, cos]]` (MuJoCo's hinge about +y: positive pitches the
nose down). Joint angles are relative to the parent link, and zero in the pose drawn here.

Masses and inertias are those of solid capsules of one density, as MuJoCo infers them from
geometry with `settotalmass`.
"""

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

Vector = tuple[float, float]
SAME_PLACE = 1e-9
"""Points closer than this (m) count as one."""


@dataclass(frozen=True)
class Capsule:
    """A solid capsule: centre in the link's frame, half length of its axis, radius (m).

    `angle` (rad) turns the axis from +z: it points along `(sin angle, cos angle)`. `friction` is
    that of its contacts; the robot's if None.
    """

    name: str
    centre: Vector
    half_length: float
    angle: float
    radius: float
    friction: float | None = None

    @property
    def volume(self) -> float:
        """Cylinder and two half balls (m^3)."""
        return pi * self.radius**2 * (2 * self.half_length + 4 / 3 * self.radius)

    @property
    def ends(self) -> tuple[Vector, Vector]:
        """Centres of the end spheres, the one along +axis first."""
        (x, z), along = self.centre, (sin(self.angle), cos(self.angle))
        reach = self.half_length
        return (
            (x + reach * along[0], z + reach * along[1]),
            (x - reach * along[0], z - reach * along[1]),
        )

    def distance(self, point: Vector) -> float:
        """From a point of the link's frame to the axis (m)."""
        start, end = (np.array(each) for each in self.ends)
        along, to = end - start, np.array(point) - start
        share = min(max(float(along @ to) / max(float(along @ along), SAME_PLACE), 0.0), 1.0)
        return float(np.linalg.norm(to - share * along))

    def inertia(self, mass: float) -> float:
        """Moment of inertia about the centre, across the axis (kg m^2)."""
        r, length = self.radius, 2 * self.half_length
        balls = mass * (4 / 3 * r) / (length + 4 / 3 * r)
        return (mass - balls) * (3 * r**2 + length**2) / 12 + balls * (
            0.4 * r**2 + 3 / 8 * length * r + length**2 / 4
        )


@dataclass(frozen=True)
class Joint:
    """A hinge to the parent: spring at rest at 0, damper, rotor inertia, stops, motor gear.

    Units: rad, N m/rad, N m s/rad, kg m^2, N m per unit of action. `axis` is 1 if positive angles
    turn the link about +y, as a positive pitch does, and -1 if about -y.
    """

    lower: float
    upper: float
    stiffness: float
    damping: float
    armature: float
    gear: float
    axis: float = 1.0


@dataclass(frozen=True)
class Link:
    """A rigid body: the place of its joint in the parent's frame, and its capsules."""

    name: str
    parent: str | None
    place: Vector
    capsules: tuple[Capsule, ...]
    joint: Joint | None


@dataclass(frozen=True)
class Robot:
    """Links, parents before children, the floating root first; every joint has a motor.

    `friction` applies to the capsules without their own.
    """

    links: tuple[Link, ...]
    total_mass: float
    gravity: float
    friction: float


def mass_of(links: tuple[Link, ...], density: float) -> float:
    """The mass of all capsules at a density (kg/m^3)."""
    return density * sum(capsule.volume for link in links for capsule in link.capsules)
