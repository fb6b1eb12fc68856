"""Constraints: which contacts and limits act in a step, and with what impulses.

A step of soft contact is smooth while the same constraints act in the same way in each substep.
MuJoCo reports how each one acts at the end of a substep, with RK4 in the last of its four stages.
"""

from collections.abc import Iterator
from hashlib import blake2b
from typing import Any, NamedTuple

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.engine import mujoco
from physics.mujoco.simulation import Simulation

_SATISFIED = int(mujoco.mjtConstraintState.mjCNSTRSTATE_SATISFIED)
_LIMITS = [
    int(mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT),
    int(mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON),
]
_FIRST_CONTACT = int(mujoco.mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS)


class Acting(NamedTuple):
    """The constraints that act in one step."""

    contact: bool
    limit: bool
    pieces: list[int]
    """For each substep, a number that identifies which constraints act and how."""


def acting(simulation: Simulation, state: FloatArray, action: FloatArray) -> Acting:
    """The constraints that act in the step of a state [n] under an action [m] within the box."""
    contact = limit = False
    pieces = []
    for data in _substeps(simulation, state, action):
        active = data.efc_type[data.efc_state != _SATISFIED]
        contact |= bool((active >= _FIRST_CONTACT).any())
        limit |= bool(np.isin(active, _LIMITS).any())
        pieces.append(_piece(data))
    return Acting(contact, limit, pieces)


def deepest_overlap(simulation: Simulation, state: FloatArray, action: FloatArray) -> float:
    """The largest overlap (m) of two geoms during a step."""
    return max(
        -float(data.contact.dist.min(initial=0.0)) for data in _substeps(simulation, state, action)
    )


def impulses(
    simulation: Simulation, state: FloatArray, action: FloatArray
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Place [3] (m) and impulse [3] (N s) of each pair of geoms that touch during a step.

    The impulse is that on the geom that moves; if both move, on the second.
    """
    force, times = np.empty(6), simulation.model.opt.timestep
    found: dict[tuple[int, int, int], list[FloatArray]] = {}
    for data in _substeps(simulation, state, action):
        count: dict[tuple[int, int], int] = {}
        for i in range(data.ncon):
            mujoco.mj_contactForce(simulation.model, data, i, force)
            if force[0] <= 0.0:
                continue
            contact = data.contact[i]
            pair = (int(contact.geom1), int(contact.geom2))
            count[pair] = count.get(pair, 0) + 1
            impulse = (
                times * _sign(simulation.model, pair) * (contact.frame.reshape(3, 3).T @ force[:3])
            )
            found.setdefault((*pair, count[pair]), []).append(
                np.concatenate([force[0] * contact.pos, impulse, force[:1]])
            )
    for each in found.values():
        total = np.sum(each, axis=0)
        yield total[:3] / total[6], total[3:6]


def _sign(model: Any, pair: tuple[int, int]) -> float:
    """1 if the second of two geoms moves, otherwise -1: MuJoCo's force acts on the second."""
    return 1.0 if model.body_weldid[model.geom_bodyid[pair[1]]] else -1.0


def _substeps(simulation: Simulation, state: FloatArray, action: FloatArray) -> Iterator[Any]:
    """The data after each substep."""
    simulation.load(state, action)
    for _ in range(simulation.substeps):
        mujoco.mj_step(simulation.model, simulation.data)
        yield simulation.data


def _piece(data: Any) -> int:
    """A number that identifies which constraints act and how."""
    parts = (data.efc_type, data.efc_id, data.efc_state, data.contact.geom)
    told = b"".join(np.ascontiguousarray(part).tobytes() for part in parts)
    return int.from_bytes(blake2b(told, digest_size=8).digest(), "little", signed=True)
