"""Body: the state of one robot, and the intermediate results of a substep.

Kernels work on one body at a time, in absolute link angles; tasks hold states in rows, in relative
angles. The map between the two is constant: an absolute angle is the sum of the relative ones from
the root to the link, each about +y.
"""

from typing import Annotated, Protocol

from physics.kernels.compiled import compiled
from physics.record import Floats, Integers
from physics.robots.dynamics.pose import ROOT, Pose
from physics.robots.lcp.complementarity import Complementarity
from physics.robots.model.mechanism import Mechanism


class Body(Protocol):
    """The arrays of a substep (substep.py); candidate i has rows 2i and 2i + 1 of J and Y."""

    q: Annotated[Floats, "n"]
    v: Annotated[Floats, "n"]
    torque: Annotated[Floats, "n"]
    """`G a`, the torque of the joint to the link's parent."""
    pose: Pose
    A: Annotated[Floats, "n", "n"]
    """Lower triangle along the tree."""
    L: Annotated[Floats, "n", "n"]
    """A, factored."""
    inverse: Annotated[Floats, "n"]
    force: Annotated[Floats, "n"]
    """f, N s."""
    free_v: Annotated[Floats, "n"]
    """Velocity without impulses."""
    change: Annotated[Floats, "n"]
    """v' - v."""
    next_v: Annotated[Floats, "n"]
    error: Annotated[Floats, "n"]
    """Scratch of the residual."""
    margin: Annotated[Floats, "k"]
    """Distance / h of every constraint."""
    candidate: Annotated[Integers, "k"]
    """The constraint behind each candidate."""
    J: Annotated[Floats, "2 * k", "n"]
    Y: Annotated[Floats, "2 * k", "n"]
    """`L^-T` of the rows of J."""
    problem: Complementarity


@compiled
def load_state(mechanism: Mechanism, states: Floats, row: int, body: Body) -> None:
    """Start from a row of states [batch, 2n]."""
    n = mechanism.parent.shape[0]
    for j in range(n):
        body.q[j] = mechanism.axis[j] * states[row, j]
        body.v[j] = mechanism.axis[j] * states[row, n + j]
        if j > ROOT:
            body.q[j] += body.q[mechanism.parent[j]]
            body.v[j] += body.v[mechanism.parent[j]]


@compiled
def load_action(mechanism: Mechanism, actions: Floats, row: int, body: Body) -> None:
    """Drive the motors with a row of actions [batch, m], clipped to [-1, 1]."""
    for j in range(body.torque.shape[0]):
        body.torque[j] = 0.0
    for m in range(mechanism.motor.shape[0]):
        j = mechanism.motor[m]
        body.torque[j] = mechanism.gear[j] * min(max(actions[row, m], -1.0), 1.0)


@compiled
def unload(mechanism: Mechanism, body: Body, states: Floats, row: int) -> None:
    """Write the state into a row of states, in relative angles."""
    n = mechanism.parent.shape[0]
    for j in range(n):
        states[row, j] = body.q[j]
        states[row, n + j] = body.v[j]
        if j > ROOT:
            states[row, j] -= body.q[mechanism.parent[j]]
            states[row, n + j] -= body.v[mechanism.parent[j]]
        states[row, j] *= mechanism.axis[j]
        states[row, n + j] *= mechanism.axis[j]
