"""Reacher: bring the tip of an arm of two links to a target, as in Gymnasium's v5.

    r = -|d| - |a|^2

    s = (two angles, target x and y, and the speeds of all four; dx, dy, dz)

Glossary:
    d   from the target to the tip (m); networks see dx and dy

As in Gymnasium, d is that of the step's last stage: not quite that of the next state. Its length
has no derivative at 0; there, 0 is used.
"""

from types import MappingProxyType
from typing import Any

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.gymnasium.assets import asset
from physics.mujoco.mujoco_task import MujocoTask

FARTHEST = 0.2
"""The largest distance of a target from the arm's base (m)."""


class Reacher(MujocoTask):
    """The outstretched arm, and a target within its reach."""

    name = "mujoco/Reacher"
    version = 1
    horizon = 50
    max_reward = 0.0
    mjcf = asset("reacher.xml")
    substeps = 2
    angles = MappingProxyType({0: 1, 1: 1})
    hidden = (6, 7, 10)
    noise_factors = MappingProxyType({6: 0.0, 7: 0.0})  # the target stays
    feature_order = (0, 2, 1, 3, 4, 5, 6, 7, 8, 9)  # cosines before sines, as in Gymnasium
    measures_as_left = True
    plane = "xy"

    @staticmethod
    def measure(model: Any, data: Any) -> FloatArray:
        """d."""
        del model
        tip, target = data.xpos[-2:]  # the last two bodies; looking them up by name takes longer
        difference: FloatArray = tip - target
        return difference

    def start(self, generator: np.random.Generator) -> FloatArray:
        """The arm with noise, and a fixed target drawn in the disc."""
        q = self.model.qpos0 + generator.uniform(-0.1, 0.1, self.model.nq)
        goal = np.full(2, np.inf)
        while np.hypot(*goal) >= FARTHEST:
            goal = generator.uniform(-FARTHEST, FARTHEST, 2)
        v = generator.uniform(-0.005, 0.005, self.model.nv)
        return np.concatenate([q[:2], goal, v[:2], np.zeros(2)])

    def rewards(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> FloatArray:
        """The negative costs of distance and control."""
        del states
        distance = np.linalg.norm(next_states[:, 8:], axis=1)
        earned: FloatArray = -distance - np.square(actions).sum(axis=1)
        return earned

    def reward_gradients(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The gradients of both costs."""
        by_next = np.zeros_like(next_states)
        distance = np.linalg.norm(next_states[:, 8:], axis=1, keepdims=True)
        by_next[:, 8:] = -next_states[:, 8:] / np.where(distance > 0.0, distance, 1.0)
        return np.zeros_like(states), -2.0 * actions, by_next
