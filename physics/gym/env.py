"""The tasks as Gymnasium environments: `gymnasium.make("d3pg/Pendulum-v0")`.

    observation   the features of the state, float64: what a network sees
    action        Box(-1, 1), float32 or float64; clipped beyond
    truncated     never: Gymnasium's TimeLimit ends episodes at the task's horizon
    info          "state"; after a step also "state_jacobian" and "action_jacobian" of that step

`reset(seed=k)` starts in `initial_states([k])`; a reset without a seed draws the next one.
`reset(options={"state": s})` starts in the state s [n].
"""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from physics.catalogue import as_task
from physics.environment import Environment, FloatArray, Transition
from physics.gym.spaces import action_space, observation_space
from physics.gym.start import checked_options, checked_states, refuse_impossible

RENDER_MODES = ("rgb_array",)
FRAMES_A_SECOND = 30
SEEDS = 2**62


class GymnasiumEnvironment(gymnasium.Env[FloatArray, NDArray[np.float32]]):
    """One episode at a time of one task."""

    metadata = {  # noqa: RUF012 - Gymnasium's name
        "render_modes": list(RENDER_MODES),
        "render_fps": FRAMES_A_SECOND,
    }

    def __init__(
        self,
        task: str | Environment | type[Environment],
        render_mode: str | None = None,
        jacobians: bool = True,
        **parameters: float,
    ) -> None:
        """Make the task.

        Args:
            task: a name that `physics.make` takes, a class or an instance.
            render_mode: None or "rgb_array".
            jacobians: whether `info` has the Jacobians of every step; a step costs less without
                them.
            parameters: values of the task's physical parameters, such as `gravity=9.81`.

        Raises:
            ValueError: for an unknown task, parameter or render mode.
        """
        self.render_mode = checked_render_mode(render_mode)
        self.task = as_task(task).with_parameters(**parameters)
        self.observation_space = observation_space(self.task)
        self.action_space = action_space(self.task)
        self._jacobians = jacobians
        self._states: FloatArray | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Start an episode; the same seed gives the same episode.

        Raises:
            ValueError: for an unknown option, and for a state outside the task's domain.
        """
        asked = checked_options(options, {"state"})
        states = checked_states(self.task, asked["state"]) if "state" in asked else None
        if states is not None:
            refuse_impossible(self.task, states)
        super().reset(seed=seed)
        if states is None:
            states = self.task.initial_states([first_seed(seed, self.np_random)])
        self._states = states
        return self.task.features(states)[0], {"state": states[0].copy()}

    def step(self, action: ArrayLike) -> tuple[FloatArray, float, bool, bool, dict[str, Any]]:
        """Advance by one step.

        Raises:
            ValueError: for an action of another shape, NaN or infinity.
            ResetNeeded: before the first reset.
        """
        actions = checked_actions(action, (self.task.action_size,))[None]
        transition, jacobians = move(self.task, self._started(), actions, self._jacobians)
        self._states = transition.next_state
        observation = self.task.features(self._states)[0]
        information = {"state": self._states[0].copy()}
        information |= {name: array[0] for name, array in jacobians.items()}
        reward, terminated = float(transition.reward[0]), bool(transition.terminated[0])
        return observation, reward, terminated, False, information

    def render(self) -> NDArray[np.uint8] | None:
        """The current state as an image, or None without a render mode."""
        if self.render_mode is None:
            return None
        return self.task.draw(self._started()[0]).rgb_array()

    def _started(self) -> FloatArray:
        """The current state [1, n]."""
        if self._states is None:
            raise ResetNeeded("call reset() first: no episode has been started")
        return self._states


def move(
    task: Environment, states: FloatArray, actions: FloatArray, jacobians: bool
) -> tuple[Transition, dict[str, FloatArray]]:
    """One step of each row, and the derivatives for `info`: arrays [batch, ...]."""
    if not jacobians:
        return task.step(states, actions), {}
    found = task.differentiate(states, actions)
    return found.transition, {
        "state_jacobian": found.state_jacobian,
        "action_jacobian": found.action_jacobian,
    }


def first_seed(seed: int | None, random: np.random.Generator) -> int:
    """The seed of an episode's start: the given one, otherwise the next one drawn."""
    return int(random.integers(SEEDS)) if seed is None else seed


def checked_actions(action: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """The action as float64. Raises ValueError for another shape."""
    actions = np.asarray(action, np.float64)
    if actions.shape != shape:
        raise ValueError(f"actions must have shape {shape}, not {actions.shape}")
    return actions


def checked_render_mode(mode: str | None) -> str | None:
    """The render mode, if it is supported. Raises ValueError otherwise."""
    if mode is not None and mode not in RENDER_MODES:
        raise ValueError(
            f"render_mode must be None or 'rgb_array', not {mode!r}; gymnasium.make shows "
            "render_mode='human' in a window, where pygame is installed"
        )
    return mode
