"""Remarks: notes for a task's audit on the cost of differences and on soft contacts."""

import time
from typing import TYPE_CHECKING

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.constraints import deepest_overlap
from physics.mujoco.derivatives import Differencing

if TYPE_CHECKING:
    from physics.mujoco.mujoco_task import MujocoTask

LOOKED_AT = 100


def remarks(task: "MujocoTask", states: FloatArray, actions: FloatArray) -> list[str]:
    """The cost and exactness of differences, and the softness of contacts, in some states."""
    states, actions = states[:LOOKED_AT], np.clip(actions[:LOOKED_AT], -1.0, 1.0)
    return [_of_differences(task, states, actions), *_of_softness(task, states, actions)]


def _of_differences(task: "MujocoTask", states: FloatArray, actions: FloatArray) -> str:
    start = time.process_time()
    task.step(states, actions)
    stepped = time.process_time()
    jacobians = task.differentiate(states, actions).state_jacobian
    ratio = (time.process_time() - stepped) / (stepped - start)
    other = np.stack(
        [
            task.jacobians(state, action, Differencing(task.difference, not task.centred))[0]
            for state, action in zip(states, actions, strict=True)
        ]
    )
    scale = np.maximum(np.abs(jacobians).max(axis=(1, 2)), 1e-3)
    apart = np.abs(other - jacobians).max(axis=(1, 2)) / scale
    kinds = ("centred", "forward") if task.centred else ("forward", "centred")
    return (
        f"its derivatives are {kinds[0]} differences of width {task.difference:g} and cost "
        f"{ratio:.0f} steps; {kinds[1]} ones lie {np.median(apart):.1e} away in the median, "
        f"{apart.max():.1e} at worst."
    )


def _of_softness(task: "MujocoTask", states: FloatArray, actions: FloatArray) -> list[str]:
    overlaps = np.array(
        [
            deepest_overlap(task.simulation, state, action)
            for state, action in zip(states, actions, strict=True)
        ]
    )
    touching = overlaps > 0.0
    if not touching.any():
        return []
    largest = np.abs(task.differentiate(states, actions).state_jacobian).max(axis=(1, 2))
    free = f"{np.median(largest[~touching]):.2g}" if (~touching).any() else "unknown"
    return [
        f"its contacts are soft: in {touching.mean():.0%} of the states bodies overlap, by "
        f"{1e3 * np.median(overlaps[touching]):.2g} mm in the median and "
        f"{1e3 * overlaps.max():.2g} mm at most. The largest entry of the Jacobian is "
        f"{np.median(largest[touching]):.2g} there in the median, elsewhere {free}."
    ]
