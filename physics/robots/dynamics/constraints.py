"""The constraints of a planar robot: flat ground for its spheres, stops for its joints.

Constraints are numbered spheres first, then stops. Each has a distance that stays positive, a
normal row Jn (its rate is `Jn v`) and, for a sphere, a tangential row Jt at its lowest point:

    gap  = height of the sphere's lowest point       Jn = (0, 1, -p_x ...)   Jt = (1, 0, p_z ...)
    room = sign (joint angle - bound)                Jn = sign at the link, -sign at its parent

with p the arm (or, on the sphere's own link, the spoke) that its link's angle turns. In Jt the
lowest point adds -radius on the sphere's own link, an offset that does not turn with it. Hence

    dJn[j] / dtheta_j = -(Jt[j] + radius on its own link)       dJt[j] / dtheta_j = Jn[j]
"""

from physics.kernels.compiled import compiled
from physics.record import Floats
from physics.robots.dynamics.pose import ROOT, Pose
from physics.robots.model.mechanism import Mechanism


@compiled
def measure(mechanism: Mechanism, q: Floats, pose: Pose, distance: Floats) -> None:
    """Fill the distance of every constraint (m, rad)."""
    spheres = mechanism.radius.shape[0]
    for k in range(spheres):
        height = pose.origin[mechanism.sphere_link[k], 1] + pose.spoke[k, 1]
        distance[k] = height - mechanism.radius[k]
    for s in range(mechanism.stop_joint.shape[0]):
        j = mechanism.stop_joint[s]
        angle = q[j] - q[mechanism.parent[j]]
        distance[spheres + s] = mechanism.stop_sign[s] * (angle - mechanism.stop_bound[s])


@compiled
def approach(mechanism: Mechanism, pose: Pose, v: Floats, k: int) -> float:
    """The rate `Jn v` of constraint k."""
    spheres = mechanism.radius.shape[0]
    if k >= spheres:
        j = mechanism.stop_joint[k - spheres]
        closing: float = mechanism.stop_sign[k - spheres] * (v[j] - v[mechanism.parent[j]])
        return closing
    j = mechanism.sphere_link[k]
    rate: float = v[1] - pose.spoke[k, 0] * v[j]
    while j > ROOT:
        parent = mechanism.parent[j]
        rate -= pose.arm[j, 0] * v[parent]
        j = parent
    return rate


@compiled
def fill_rows(mechanism: Mechanism, pose: Pose, k: int, J: Floats, row: int) -> None:
    """Write Jn of constraint k into `J[row]` and Jt (0 for a stop) into the row after it."""
    spheres = mechanism.radius.shape[0]
    for i in range(mechanism.parent.shape[0]):
        J[row, i] = 0.0
        J[row + 1, i] = 0.0
    if k >= spheres:
        j = mechanism.stop_joint[k - spheres]
        J[row, j] = mechanism.stop_sign[k - spheres]
        J[row, mechanism.parent[j]] = -mechanism.stop_sign[k - spheres]
        return
    j = mechanism.sphere_link[k]
    J[row, 1] = 1.0
    J[row + 1, 0] = 1.0
    J[row, j] = -pose.spoke[k, 0]
    J[row + 1, j] = pose.spoke[k, 1] - mechanism.radius[k]
    while j > ROOT:
        parent = mechanism.parent[j]
        J[row, parent] = -pose.arm[j, 0]
        J[row + 1, parent] = pose.arm[j, 1]
        j = parent
