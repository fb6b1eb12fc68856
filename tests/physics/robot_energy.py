"""The energy of any robot, from its mass matrix and the moments of its links."""

import numpy as np

from physics.environment import FloatArray
from physics.robots.task import RobotTask


def energy(task: RobotTask, states: FloatArray) -> FloatArray:
    """Kinetic energy (rotors included), height, springs, up to a constant (J)."""
    n = states.shape[1] // 2
    q, v = np.ascontiguousarray(states[:, :n]), states[:, n:]
    kinetic = np.einsum("bi,bij,bj->b", v, task.mass_matrix(q), v) / 2.0
    # the forces at rest are minus the potential's slope, so M's row of z gives its height part
    mechanism = task.mechanism[0]
    absolute = mechanism.axis * q
    for j in range(3, n):
        absolute[:, j] += absolute[:, mechanism.parent[j]]
    height = mechanism.mass * q[:, 1]
    for j in range(2, n):
        x, z = mechanism.moment[j]
        height += z * np.cos(absolute[:, j]) - x * np.sin(absolute[:, j])
    spring = (mechanism.stiffness * q**2).sum(axis=1) / 2.0
    total: FloatArray = kinetic + mechanism.gravity * height + spring
    return total
