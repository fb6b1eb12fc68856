"""Tangent: converts derivatives in MuJoCo's tangent space to the coordinates of a state.

A quaternion has four coordinates and moves in three directions: a joint's angular velocity w turns
it by `dq = q (0, w) / 2`. A step normalises the quaternions that it begins with, so that the next
state is a function of all four coordinates, and its Jacobian is

    J = G(q') A H(q),    G = E^T / 2,    H = 2 E / |q|

with A the Jacobian between the tangent spaces, [2 nv + na, 2 nv + na], and E(q) [3, 4] of the
quaternion. J is 0 along the quaternion itself, which changes no rotation. All other coordinates are
their own directions.
"""

from typing import Any

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.engine import mujoco

_QUATERNION_AT = {int(mujoco.mjtJoint.mjJNT_FREE): 3, int(mujoco.mjtJoint.mjJNT_BALL): 0}
"""Type of joint -> where its quaternion begins among its coordinates."""


def quaternions_of(model: Any) -> list[tuple[int, int]]:
    """For each quaternion, its place in qpos and the place of its rotation in qvel."""
    return [
        (int(coordinate) + _QUATERNION_AT[kind], int(speed) + _QUATERNION_AT[kind])
        for kind, coordinate, speed in zip(
            model.jnt_type.tolist(), model.jnt_qposadr, model.jnt_dofadr, strict=True
        )
        if kind in _QUATERNION_AT
    ]


def from_coordinates(model: Any, state: FloatArray) -> FloatArray:
    """H [2 nv + na, nq + nv + na]: the derivative of the tangent in the coordinates."""
    H = _blocks(model)
    for place, rotation in quaternions_of(model):
        quaternion = state[place : place + 4]
        length = np.linalg.norm(quaternion)
        H[rotation : rotation + 3, place : place + 4] = (
            2.0 * _directions(quaternion / length) / length
        )
    return H


def to_coordinates(model: Any, state: FloatArray) -> FloatArray:
    """G [nq + nv + na, 2 nv + na]: the derivative of the coordinates in the tangent."""
    G = _blocks(model).T
    for place, rotation in quaternions_of(model):
        G[place : place + 4, rotation : rotation + 3] = _directions(state[place : place + 4]).T / 2
    return G


def _blocks(model: Any) -> FloatArray:
    """H [2 nv + na, nq + nv + na] for all but the quaternions."""
    H = np.zeros((2 * model.nv + model.na, model.nq + model.nv + model.na))
    row = column = 0
    for place, rotation in [*quaternions_of(model), (model.nq, model.nv)]:
        size = rotation - row
        H[row:rotation, column:place] = np.eye(size)
        row, column = rotation + 3, place + 4
    rest = model.nv + model.na
    H[model.nv :, model.nq :] = np.eye(rest)
    return H


def _directions(quaternion: FloatArray) -> FloatArray:
    """E [3, 4] of a quaternion of length 1: `w = 2 E dq`."""
    w, x, y, z = quaternion
    return np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
