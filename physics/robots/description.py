"""A planar robot as data: links in a tree, the capsules they are made of, joints and motors.

Frames: x forward, z up; a link turned by `theta` carries its own vector `p` to the world as
`R(theta) p` with `R = [[cos, sin], [-sin, cos]]` (MuJoCo's hinge about +y: positive pitches the
nose down). Joint angles are relative to the parent link, and zero in the pose drawn here.

`build` turns the description into a `Mechanism`, the constant arrays that the compiled kernels
read. They work in absolute link angles, degrees of freedom `(x, z, theta_0, theta_1, ...)`, in
which the mass matrix consists of dot products of constant vectors that only turn:

    moment_j   first moment of mass about joint j of link j and of all that hangs on it, each
               child's mass put at its joint (in link j's frame, kg m)
    inertia_j  second moment about joint j of the same masses (kg m^2)
    arm_j      place of joint j in its parent's frame (m)

Masses and inertias are those of solid capsules of one density, as MuJoCo infers them from
geometry with `settotalmass`.
"""

from dataclasses import dataclass
from math import cos, pi, sin
from typing import Annotated, Any, Protocol

import numpy as np

from physics.record import Floats, Integers, Records, dtype

Vector = tuple[float, float]


@dataclass(frozen=True)
class Capsule:
    """A solid capsule: centre in the link's frame, half length of its axis, radius (m).

    `angle` (rad) turns the axis from +z: it points along `(sin angle, cos angle)`.
    """

    name: str
    centre: Vector
    half_length: float
    angle: float
    radius: float

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

    Units: rad, N m/rad, N m s/rad, kg m^2, N m per unit of action.
    """

    lower: float
    upper: float
    stiffness: float
    damping: float
    armature: float
    gear: float


@dataclass(frozen=True)
class Link:
    """A rigid body: where its joint sits in the parent's frame, and what it is made of."""

    name: str
    parent: str | None
    place: Vector
    capsules: tuple[Capsule, ...]
    joint: Joint | None


@dataclass(frozen=True)
class Robot:
    """Links, parents before children, the floating root first; all joints but the root's driven."""

    links: tuple[Link, ...]
    total_mass: float
    gravity: float
    friction: float


class Mechanism(Protocol):
    """A robot as the kernels see it; n degrees of freedom, m motors, c spheres, l stops.

    Arrays of length n are indexed by degree of freedom: 0 and 1 are x and z, 2 the root's angle.
    """

    parent: Annotated[Integers, "n"]
    """The degree of freedom this one hangs on; -1 for x."""
    arm: Annotated[Floats, "n", "2"]
    moment: Annotated[Floats, "n", "2"]
    inertia: Annotated[Floats, "n"]
    armature: Annotated[Floats, "n"]
    damping: Annotated[Floats, "n"]
    stiffness: Annotated[Floats, "n"]
    gear: Annotated[Floats, "n"]
    motor: Annotated[Integers, "m"]
    """Degree of freedom of the driven link."""
    sphere_link: Annotated[Integers, "c"]
    """Degree of freedom of the sphere's link."""
    sphere: Annotated[Floats, "c", "2"]
    """Centre in the link's frame."""
    radius: Annotated[Floats, "c"]
    stop_joint: Annotated[Integers, "l"]
    """Degree of freedom of the joint's outer link."""
    stop_sign: Annotated[Floats, "l"]
    """Room = sign (angle - bound)."""
    stop_bound: Annotated[Floats, "l"]
    friction: float
    mass: float
    gravity: float


def sizes(robot: Robot) -> dict[str, int]:
    """What the letters in the shapes of layouts stand for."""
    joints = sum(link.joint is not None for link in robot.links)
    spheres = 2 * sum(len(link.capsules) for link in robot.links)
    return {
        "n": len(robot.links) + 2,
        "m": joints,
        "c": spheres,
        "l": 2 * joints,
        "k": spheres + 2 * joints,
        "p": 2 * (len(robot.links) + 2) + joints,
    }


def build(robot: Robot) -> Records:
    """Derive the mechanism of a robot: a read-only array [1] of its record."""
    moment, inertia = _moments(robot)
    joints = [(2 + k, link.joint) for k, link in enumerate(robot.links) if link.joint is not None]
    stops = [
        (j, sign, bound)
        for j, joint in joints
        for sign, bound in ((1.0, joint.lower), (-1.0, joint.upper))
    ]
    spheres = [
        (2 + k, end, capsule.radius)
        for k, link in enumerate(robot.links)
        for capsule in link.capsules
        for end in capsule.ends
    ]
    mechanism = np.zeros(1, dtype(Mechanism, **sizes(robot)))
    fields: dict[str, Any] = {
        "parent": [-1, 0, 1] + [2 + parent for parent in _parents(robot)[1:]],
        "arm": [(0.0, 0.0), (0.0, 0.0), *(link.place for link in robot.links)],
        "moment": moment,
        "inertia": inertia,
        "motor": [j for j, _ in joints],
        "sphere_link": [link for link, _, _ in spheres],
        "sphere": [centre for _, centre, _ in spheres],
        "radius": [radius for _, _, radius in spheres],
        "stop_joint": [j for j, _, _ in stops],
        "stop_sign": [sign for _, sign, _ in stops],
        "stop_bound": [bound for _, _, bound in stops],
        "friction": robot.friction,
        "mass": robot.total_mass,
        "gravity": robot.gravity,
    }
    for name, values in fields.items():
        mechanism[0][name] = values
    for j, joint in joints:
        for name in ("armature", "damping", "stiffness", "gear"):
            mechanism[0][name][j] = getattr(joint, name)
    mechanism.setflags(write=False)
    return mechanism


def _parents(robot: Robot) -> list[int]:
    """The index of each link's parent; -1 for the root."""
    names = [link.name for link in robot.links]
    return [-1 if link.parent is None else names.index(link.parent) for link in robot.links]


def _moments(robot: Robot) -> tuple[Floats, Floats]:
    """`moment` [n, 2] and `inertia` [n] of the module's docstring, 0 for x and z."""
    density = robot.total_mass / sum(c.volume for link in robot.links for c in link.capsules)
    n = len(robot.links) + 2
    masses, moment, inertia = np.zeros(n), np.zeros((n, 2)), np.zeros(n)
    for k, parent in reversed(list(enumerate(_parents(robot)))):
        j, link = 2 + k, robot.links[k]
        for capsule in link.capsules:
            mass, centre = density * capsule.volume, np.array(capsule.centre)
            masses[j] += mass
            moment[j] += mass * centre
            inertia[j] += capsule.inertia(mass) + mass * centre @ centre
        if parent >= 0:
            place = np.array(link.place)
            masses[2 + parent] += masses[j]
            moment[2 + parent] += masses[j] * place
            inertia[2 + parent] += masses[j] * place @ place
    return moment, inertia
