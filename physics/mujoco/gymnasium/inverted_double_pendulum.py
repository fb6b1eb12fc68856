"""InvertedDoublePendulum: balance two poles on a cart, as in Gymnasium's v5.

    r = 10 - 0.01 x^2 - (y - 2)^2 - 0.001 v1^2 - 0.005 v2^2      without the 10 where the step ends
    ends when y <= 1

    s = (cart, hinge, hinge2, and their speeds v0, v1, v2; x, y, f)

Glossary:
    x, y   place of the upper pole's tip (m), which networks do not see
    f      force (N) of the rail's ends on the cart, clipped to 10 for networks

As in Gymnasium, x, y and f are those of the step's last stage: not quite those of the next state.
"""

from types import MappingProxyType
from typing import Any

import numpy as np

from physics.environment import BoolArray, FloatArray
from physics.mujoco.gymnasium.assets import asset
from physics.mujoco.mujoco_task import MujocoTask

BONUS = 10.0
ENOUGH = 1.0
X, Y = 6, 7
OF_PLACE, OF_SPEED = (0.01, 1.0), (1e-3, 5e-3)
"""Costs of x^2 and (y - 2)^2, of v1^2 and v2^2."""


class InvertedDoublePendulum(MujocoTask):
    """The cart with its two poles upright, and noise."""

    name = "mujoco/InvertedDoublePendulum"
    version = 1
    horizon = 1000
    max_reward = 9.36
    mjcf = asset("inverted_double_pendulum.xml")
    substeps = 5
    angles = MappingProxyType({1: 1, 2: 1})
    hidden = (X, Y)
    clipped = MappingProxyType({3: 10.0, 4: 10.0, 5: 10.0, 8: 10.0})
    feature_order = (0, 2, 4, 1, 3, 5, 6, 7, 8)  # sines before cosines, as in Gymnasium
    measures_as_left = True

    @staticmethod
    def measure(model: Any, data: Any) -> FloatArray:
        """x, y and f."""
        del model
        x, _, y = data.site_xpos[0]
        return np.array([x, y, data.qfrc_constraint[0]])

    def start(self, generator: np.random.Generator) -> FloatArray:
        """The upright pose with noise."""
        q = self.model.qpos0 + generator.uniform(-0.1, 0.1, self.model.nq)
        return np.concatenate([q, 0.1 * generator.standard_normal(self.model.nv)])

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """See `Environment.sample`; every third cart is at an end of the rail."""
        states, actions = super().sample(generator, count)
        side = generator.choice([-1.0, 1.0], len(states[::3]))
        states[::3, 0] = side * generator.uniform(0.9, 1.02, len(side))
        states[::3, 3] = side * generator.uniform(-1.0, 5.0, len(side))
        return states, actions

    def rewards(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> FloatArray:
        """The bonus less the penalties."""
        del states, actions
        off, speeds = _off(next_states), next_states[:, 4:6]
        bonus = np.where(self.ends(next_states), 0.0, BONUS)
        earned: FloatArray = bonus - off**2 @ OF_PLACE - speeds**2 @ OF_SPEED
        return earned

    def reward_gradients(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The gradients of the penalties; the bonus is piecewise constant."""
        by_next = np.zeros_like(next_states)
        by_next[:, [X, Y]] = -2.0 * _off(next_states) * OF_PLACE
        by_next[:, 4:6] = -2.0 * next_states[:, 4:6] * OF_SPEED
        return np.zeros_like(states), np.zeros_like(actions), by_next

    def ends(self, next_states: FloatArray) -> BoolArray:
        """Whether the tip is at or below 1 m."""
        low: BoolArray = next_states[:, Y] <= ENOUGH
        return low


def _off(states: FloatArray) -> FloatArray:
    """The offset [batch, 2] of the tip from the point 2 m above the middle of the rail."""
    return states[:, [X, Y]] - (0.0, 2.0)
