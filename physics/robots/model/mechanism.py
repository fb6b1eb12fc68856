"""A planar robot as the constant arrays that the compiled kernels read.

The kernels work in absolute link angles, degrees of freedom `(x, z, theta_0, theta_1, ...)`, in
which the mass matrix consists of dot products of constant vectors that only turn:

    moment_j   first moment of mass about joint j of link j and of all links beyond it, with each
               child's mass placed at its joint (in link j's frame, kg m)
    inertia_j  second moment about joint j of the same masses (kg m^2)
    arm_j      place of joint j in its parent's frame (m)
"""

from typing import Annotated, Any, Protocol

import numpy as np

from physics.record import Floats, Integers, Records, dtype
from physics.robots.model.description import Capsule, Robot, mass_of
from physics.robots.model.spheres import touching


class Mechanism(Protocol):
    """A robot as kernels read it; n degrees of freedom, m motors, c spheres, l stops.

    Arrays of length n are indexed by degree of freedom: 0 and 1 are x and z, 2 the root's angle.
    """

    parent: Annotated[Integers, "n"]
    """The parent degree of freedom; -1 for x."""
    arm: Annotated[Floats, "n", "2"]
    moment: Annotated[Floats, "n", "2"]
    inertia: Annotated[Floats, "n"]
    armature: Annotated[Floats, "n"]
    damping: Annotated[Floats, "n"]
    stiffness: Annotated[Floats, "n"]
    gear: Annotated[Floats, "n"]
    """About +y."""
    axis: Annotated[Floats, "n"]
    """1 or -1; joint angles and their rates are those about +y times this."""
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
    """Room = sign (angle - bound), the angle about +y."""
    stop_bound: Annotated[Floats, "l"]
    """About +y."""
    friction: Annotated[Floats, "c"]
    mass: float
    gravity: float


def sizes(robot: Robot) -> dict[str, int]:
    """The sizes that the letters in the shapes of layouts stand for."""
    joints = sum(link.joint is not None for link in robot.links)
    spheres = len(touching(robot))
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
        (j, joint.axis * sign, joint.axis * bound)
        for j, joint in joints
        for sign, bound in ((1.0, joint.lower), (-1.0, joint.upper))
    ]
    spheres = touching(robot)
    mechanism = np.zeros(1, dtype(Mechanism, **sizes(robot)))
    fields: dict[str, Any] = {
        "parent": [-1, 0, 1] + [2 + parent for parent in _parents(robot)[1:]],
        "arm": [(0.0, 0.0), (0.0, 0.0), *(link.place for link in robot.links)],
        "moment": moment,
        "inertia": inertia,
        "motor": [j for j, _ in joints],
        "axis": 1.0,
        "sphere_link": [sphere.link for sphere in spheres],
        "sphere": [sphere.centre for sphere in spheres],
        "radius": [sphere.capsule.radius for sphere in spheres],
        "friction": [_friction(robot, sphere.capsule) for sphere in spheres],
        "stop_joint": [j for j, _, _ in stops],
        "stop_sign": [sign for _, sign, _ in stops],
        "stop_bound": [bound for _, _, bound in stops],
        "mass": robot.total_mass,
        "gravity": robot.gravity,
    }
    for name, values in fields.items():
        mechanism[0][name] = values
    for j, joint in joints:
        for name in ("armature", "damping", "stiffness", "gear", "axis"):
            mechanism[0][name][j] = getattr(joint, name)
        mechanism[0]["gear"][j] *= joint.axis
    mechanism.setflags(write=False)
    return mechanism


def _friction(robot: Robot, capsule: Capsule) -> float:
    """The capsule's own friction, or the robot's."""
    return robot.friction if capsule.friction is None else capsule.friction


def _parents(robot: Robot) -> list[int]:
    """The index of each link's parent; -1 for the root."""
    names = [link.name for link in robot.links]
    return [-1 if link.parent is None else names.index(link.parent) for link in robot.links]


def _moments(robot: Robot) -> tuple[Floats, Floats]:
    """`moment` [n, 2] and `inertia` [n] of the module's docstring, 0 for x and z."""
    density = robot.total_mass / mass_of(robot.links, 1.0)
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
