"""Planar articulated bodies in absolute link angles: mass matrix, bias, sphere kinematics.

Degrees of freedom `(x, z, theta_0, theta_1, ...)`. With `a_j`, `w_j` the arm and the moment of
link j turned to the world (model/description.py), `'` the derivative in the angle that turns them
(`p' = (p_z, -p_x)`, `p'' = -p`), and `a` the arm that leads from ancestor i towards j:

    M[x, j], M[z, j] = w_j'          M[j, j] = inertia_j          M[j, i] = a . w_j
    N[j, i] = a' . w_j               dM[j, i]/dtheta_i = N[j, i]  dM[j, i]/dtheta_j = -N[j, i]
    c[x], c[z] = -sum_j omega_j^2 w_j + (0, mass g)
    c[i] = -omega_j^2 N[j, i],  c[j] = omega_i^2 N[j, i]  summed over pairs;  c[j] -= g w_j[x]

so only rotations of constant vectors are evaluated. Joint quantities (relative angles) are
differences between a link and its parent, and keep the tree's sparsity.
"""

from math import cos, sin
from typing import Annotated, Protocol

from physics.kernels.compiled import compiled
from physics.record import Floats
from physics.robots.model.mechanism import Mechanism

ROOT = 2
"""Index of the root link's angle; x and z come before it."""


class Pose(Protocol):
    """The quantities that depend on the coordinates alone, in the world's frame."""

    turn: Annotated[Floats, "n", "2"]
    """Cosine and sine of the link's angle."""
    arm: Annotated[Floats, "n", "2"]
    """From the parent's joint to this link's."""
    moment: Annotated[Floats, "n", "2"]
    origin: Annotated[Floats, "n", "2"]
    """The link's joint."""
    spoke: Annotated[Floats, "c", "2"]
    """From the link's joint to the sphere's centre."""
    M: Annotated[Floats, "n", "n"]
    """Lower triangle along the tree, without armature."""
    N: Annotated[Floats, "n", "n"]
    """Lower triangle along the tree."""


@compiled
def _turn(pose: Pose, link: int, vectors: Floats, k: int, turned: Floats) -> None:
    """Turn vector k of the link's frame to the world."""
    c, s = pose.turn[link, 0], pose.turn[link, 1]
    x, z = vectors[k, 0], vectors[k, 1]
    turned[k, 0] = c * x + s * z
    turned[k, 1] = c * z - s * x


@compiled
def _turn_links(mechanism: Mechanism, q: Floats, pose: Pose) -> None:
    """Turn arms, moments and spokes to the world, and place the joints."""
    parent = mechanism.parent
    pose.origin[ROOT, 0] = q[0] + mechanism.arm[ROOT, 0]
    pose.origin[ROOT, 1] = q[1] + mechanism.arm[ROOT, 1]
    for j in range(ROOT, parent.shape[0]):
        pose.turn[j, 0] = cos(q[j])
        pose.turn[j, 1] = sin(q[j])
        _turn(pose, j, mechanism.moment, j, pose.moment)
        if j > ROOT:
            _turn(pose, parent[j], mechanism.arm, j, pose.arm)
            pose.origin[j, 0] = pose.origin[parent[j], 0] + pose.arm[j, 0]
            pose.origin[j, 1] = pose.origin[parent[j], 1] + pose.arm[j, 1]
    for k in range(mechanism.sphere_link.shape[0]):
        _turn(pose, mechanism.sphere_link[k], mechanism.sphere, k, pose.spoke)


@compiled
def place(mechanism: Mechanism, q: Floats, pose: Pose) -> None:
    """Fill the pose for absolute coordinates q [n]."""
    _turn_links(mechanism, q, pose)
    parent, moment, arm = mechanism.parent, pose.moment, pose.arm
    pose.M[0, 0] = mechanism.mass
    pose.M[1, 0] = 0.0
    pose.M[1, 1] = mechanism.mass
    for j in range(ROOT, parent.shape[0]):
        pose.M[j, 0] = moment[j, 1]
        pose.M[j, 1] = -moment[j, 0]
        pose.M[j, j] = mechanism.inertia[j]
        k, i = j, parent[j]
        while i >= ROOT:
            pose.M[j, i] = arm[k, 0] * moment[j, 0] + arm[k, 1] * moment[j, 1]
            pose.N[j, i] = arm[k, 1] * moment[j, 0] - arm[k, 0] * moment[j, 1]
            k, i = i, parent[i]


@compiled
def bias(mechanism: Mechanism, pose: Pose, v: Floats, c: Floats) -> None:
    """Fill c [n] with Coriolis, centrifugal and gravity forces at velocity v."""
    parent = mechanism.parent
    c[0] = 0.0
    c[1] = mechanism.mass * mechanism.gravity
    for j in range(ROOT, parent.shape[0]):
        square = v[j] * v[j]
        c[0] -= square * pose.moment[j, 0]
        c[1] -= square * pose.moment[j, 1]
        c[j] = -mechanism.gravity * pose.moment[j, 0]
        i = parent[j]
        while i >= ROOT:
            c[j] += v[i] * v[i] * pose.N[j, i]
            c[i] -= square * pose.N[j, i]
            i = parent[i]
