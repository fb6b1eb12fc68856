"""HalfCheetah, Hopper, Walker2d and Swimmer: move forward, as in Gymnasium's v5.

    r = (x' - x) / T + bonus - cost |a|^2,    bonus only where the step does not end the episode

Glossary:
    x      place along the ground (m), qpos[0], which no network sees
    T      seconds of a step
    cost   factor of the control cost

A step's reward has no bound here, so `max_reward` is a reference value, not a bound: Gymnasium's
threshold for Swimmer (a return of 360 in 1,000 steps) and, rounded up, for Hopper (a return of
3,800), the constant of the project's own HalfCheetah, and an estimate for Walker2d, which has no
threshold.

Hopper and Walker2d end where they are no longer healthy, and networks see their speeds clipped to
10, as in Gymnasium. Actions are in the box, as these models' controls are.
"""

from pathlib import Path
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from physics.environment import BoolArray, FloatArray
from physics.mujoco.engine import mujoco
from physics.mujoco.gymnasium.assets import asset
from physics.mujoco.model import Model, compiled
from physics.mujoco.mujoco_task import MujocoTask

FASTEST_SEEN = 10.0


class Running(MujocoTask):
    """A model whose reward is its speed along the first coordinate."""

    control_cost: ClassVar[float]
    bonus: ClassVar[float] = 0.0
    start_noise: ClassVar[float]
    """The largest distance of a start's coordinates from the model's own."""

    def start(self, generator: np.random.Generator) -> FloatArray:
        """The model's own state, with noise in all coordinates."""
        return self._rest() + generator.uniform(
            -self.start_noise, self.start_noise, self.state_size
        )

    def rewards(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> FloatArray:
        """Speed and bonus less the cost."""
        forward = (next_states[:, 0] - states[:, 0]) / self.step_seconds
        bonus = np.where(self.ends(next_states), 0.0, self.bonus)
        earned: FloatArray = forward + bonus - self.control_cost * _squares(actions)
        return earned

    def reward_gradients(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The gradients of the speed and the cost; the bonus is piecewise constant."""
        by_state, by_next = np.zeros_like(states), np.zeros_like(next_states)
        by_state[:, 0], by_next[:, 0] = -1.0 / self.step_seconds, 1.0 / self.step_seconds
        return by_state, -2.0 * self.control_cost * actions, by_next


class HalfCheetah(Running):
    """The half cheetah, which never falls."""

    name = "mujoco/HalfCheetah"
    version = 1
    horizon = 1000
    max_reward = 10.0
    mjcf = asset("half_cheetah.xml")
    substeps = 5
    hidden = (0,)
    control_cost = 0.1
    start_noise = 0.1

    @classmethod
    def compiled_model(cls) -> Model:
        """The model; a call sets its mass, since the file's attribute for it is deprecated."""
        model = compiled(Path(cls.mjcf).read_text().replace('settotalmass="14"', ""))
        mujoco.mj_setTotalmass(model, 14.0)
        mujoco.mj_setConst(model, mujoco.MjData(model))
        return model

    def start(self, generator: np.random.Generator) -> FloatArray:
        """The model's own pose with noise, and normal speeds."""
        q = self.model.qpos0 + generator.uniform(-0.1, 0.1, self.model.nq)
        return np.concatenate([q, 0.1 * generator.standard_normal(self.model.nv)])


class Hopper(Running):
    """The hopper; an episode ends when it leans or sinks."""

    name = "mujoco/Hopper"
    version = 1
    horizon = 1000
    max_reward = 4.0
    mjcf = asset("hopper.xml")
    substeps = 4
    hidden = (0,)
    clipped = MappingProxyType(dict.fromkeys(range(6, 12), FASTEST_SEEN))
    control_cost = 1e-3
    bonus = 1.0
    start_noise = 5e-3

    def ends(self, next_states: FloatArray) -> BoolArray:
        """Whether it is too low or tilted, or any other coordinate but x is beyond 100."""
        rest = (np.abs(next_states[:, 2:]) < 100.0).all(axis=1)
        healthy: BoolArray = rest & (next_states[:, 1] > 0.7) & (np.abs(next_states[:, 2]) < 0.2)
        return ~healthy


class Walker2d(Running):
    """The walker; an episode ends when it falls."""

    name = "mujoco/Walker2d"
    version = 1
    horizon = 1000
    max_reward = 5.0
    mjcf = asset("walker2d_v5.xml")
    substeps = 4
    hidden = (0,)
    clipped = MappingProxyType(dict.fromkeys(range(9, 18), FASTEST_SEEN))
    control_cost = 1e-3
    bonus = 1.0
    start_noise = 5e-3

    def ends(self, next_states: FloatArray) -> BoolArray:
        """Whether it is too low, too high or tilted."""
        height, pitch = next_states[:, 1], next_states[:, 2]
        healthy: BoolArray = (height > 0.8) & (height < 2.0) & (np.abs(pitch) < 1.0)
        return ~healthy


class Swimmer(Running):
    """The swimmer of three links, in a viscous fluid."""

    name = "mujoco/Swimmer"
    version = 1
    horizon = 1000
    max_reward = 0.36
    mjcf = asset("swimmer.xml")
    substeps = 4
    hidden = (0, 1)
    plane = "xy"
    control_cost = 1e-4
    start_noise = 0.1


def _squares(actions: FloatArray) -> FloatArray:
    """`|a|^2` of each row."""
    squares: FloatArray = np.einsum("ij,ij->i", actions, actions)
    return squares
