"""Gymnasium's face of the tasks: `gymnasium.make("d3pg/Pendulum-v0")`.

    observation   the features of the state: what a network sees
    action        Box(-1, 1)
    truncated     at the task's horizon
    info          "state"; after a step also "state_jacobian" and "action_jacobian" of that step

`reset(seed=k)` starts in `initial_states([k])`; a reset without a seed draws the next one.
"""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from physics.catalogue import make, names
from physics.environment import FloatArray


class GymnasiumEnvironment(gymnasium.Env[FloatArray, NDArray[np.floating[Any]]]):
    """One episode at a time of one task."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012 - Gymnasium's name

    def __init__(self, task: str, render_mode: str | None = None) -> None:
        """Make the task of that name.

        Args:
            task: a name that `physics.names()` lists.
            render_mode: None or "rgb_array".
        """
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode must be None or 'rgb_array', not {render_mode!r}")
        self.task = make(task)
        self.render_mode = render_mode
        # A cosine or sine is bounded; nothing else is promised.
        angular = self.task.feature_map.offsets == 0.0
        bound = np.where(angular, 1.0, np.inf)
        self.observation_space = gymnasium.spaces.Box(-bound, bound, dtype=np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self.task.action_size,), np.float64)
        self._state = np.zeros((1, self.task.state_size))
        self._elapsed = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Start an episode; the same seed, the same episode."""
        super().reset(seed=seed, options=options)
        if seed is None:
            seed = int(self.np_random.integers(2**62))
        self._state = self.task.initial_states([seed])
        self._elapsed = 0
        return self.task.features(self._state)[0], {"state": self._state[0].copy()}

    def step(
        self, action: NDArray[np.floating[Any]]
    ) -> tuple[FloatArray, float, bool, bool, dict[str, Any]]:
        """Advance by one step; actions outside the box are clipped."""
        linearization = self.task.differentiate(
            self._state, np.asarray(action, np.float64).reshape(1, -1)
        )
        self._state, reward, terminated = linearization.transition
        self._elapsed += 1
        information = {
            "state": self._state[0].copy(),
            "state_jacobian": linearization.state_jacobian[0],
            "action_jacobian": linearization.action_jacobian[0],
        }
        truncated = self._elapsed >= self.task.horizon
        observation = self.task.features(self._state)[0]
        return observation, float(reward[0]), bool(terminated[0]), truncated, information

    def render(self) -> NDArray[np.uint8] | None:
        """The present state as an image, or None without a render mode."""
        if self.render_mode is None:
            return None
        return self.task.draw(self._state[0]).rgb_array()


def register() -> None:
    """Register every task as `d3pg/<Name>-v0`; Gymnasium calls this through its entry point."""
    for name in names():
        if f"d3pg/{name}-v0" not in gymnasium.registry:
            gymnasium.register(
                f"d3pg/{name}-v0",
                entry_point="physics.gymnasium_env:GymnasiumEnvironment",
                kwargs={"task": name},
            )
