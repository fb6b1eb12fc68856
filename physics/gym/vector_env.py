"""The tasks as vector environments: `gymnasium.make_vec("d3pg/Pendulum-v0", num_envs=16)`.

All episodes advance in one call of `Environment.step` or `differentiate`. The results equal, bit
for bit, those of `gymnasium.vector.SyncVectorEnv` with as many `GymnasiumEnvironment`s: each row
has its own random generator, and `info` has an array [num_envs, ...] for each entry, and beside it,
under "_" and its name, bool [num_envs], the rows for which the entry is set. The autoreset modes
are Gymnasium's:

    NEXT_STEP   the step after an episode's end starts the next one; its action does not count
    SAME_STEP   the end and the next start share a step; what ended is in "final_obs", "final_info"
    DISABLED    ended rows wait for `reset(options={"reset_mask": mask})`
"""

import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from physics.catalogue import as_task
from physics.environment import BoolArray, Environment, FloatArray
from physics.gym.env import (
    FRAMES_A_SECOND,
    RENDER_MODES,
    checked_actions,
    checked_render_mode,
    first_seed,
    move,
)
from physics.gym.spaces import action_space, observation_space
from physics.gym.start import checked_options, checked_states, refuse_impossible

Info = dict[str, Any]
Seeds = int | Sequence[int | None] | None
_Seeded = tuple[np.random.Generator, int]


class GymnasiumVectorEnvironment(VectorEnv[FloatArray, NDArray[np.float32], NDArray[Any]]):
    """Many episodes of one task, side by side."""

    def __init__(
        self,
        task: str | Environment | type[Environment],
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        jacobians: bool = True,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **parameters: float,
    ) -> None:
        """Make the task.

        Args:
            task: a name that `physics.make` takes, a class or an instance.
            num_envs: how many episodes run at a time, at least 1.
            max_episode_steps: after how many steps an episode is truncated; None for the task's
                horizon, -1 for never, as in `gymnasium.make`.
            render_mode: None or "rgb_array".
            jacobians: whether `info` has the Jacobians of every step; a step costs less without
                them.
            autoreset_mode: one of Gymnasium's modes, or its value ("NextStep").
            parameters: values of the task's physical parameters, such as `gravity=9.81`.

        Raises:
            ValueError: for an unknown task, parameter or mode, and for numbers out of range.
        """
        self.render_mode = checked_render_mode(render_mode)
        self.task = as_task(task).with_parameters(**parameters)
        self.num_envs = _at_least_one(num_envs, "num_envs")
        self._limit = _time_limit(max_episode_steps, self.task.horizon)
        self._mode = AutoresetMode(autoreset_mode)
        self.metadata = {
            "render_modes": list(RENDER_MODES),
            "render_fps": FRAMES_A_SECOND,
            "autoreset_mode": self._mode,
        }
        self.single_observation_space = observation_space(self.task)
        self.single_action_space = action_space(self.task)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._jacobians = jacobians
        self._seeded = [seeding.np_random() for _ in range(num_envs)]
        self._states = np.zeros((num_envs, self.task.state_size))
        self._elapsed = np.zeros(num_envs, np.int64)
        self._ended = np.zeros(num_envs, np.bool_)
        self._is_started = False

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The random generator of each row."""
        return tuple(random for random, _ in self._seeded)

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """The seed of each row's random generator."""
        return tuple(seed for _, seed in self._seeded)

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, Info]:
        """Start an episode in every row, or in those of `options["reset_mask"]`.

        Args:
            seed: row i starts from `seed + i`, from `seed[i]`, or from the next seed it draws.
            options: "state", a state [n] for all rows or one for each [num_envs, n];
                "reset_mask", bool [num_envs].

        Raises:
            ValueError: for unknown options, for states outside the task's domain, for a mask of
                another shape or dtype or without a row, and for too few or too many seeds.
            ResetNeeded: for a mask that leaves out rows in which no episode was ever started.
        """
        asked = checked_options(options, {"state", "reset_mask"})
        rows = self._checked_mask(asked.get("reset_mask"))
        seeds = self._checked_seeds(seed)
        states = None
        if "state" in asked:
            states = checked_states(self.task, asked["state"], self.num_envs)
            refuse_impossible(self.task, states[rows])
        self._seeded = self._reseeded(rows, seeds)
        self._start(rows, self._drawn(rows, seeds) if states is None else states[rows])
        self._is_started = True
        return self.task.features(self._states), _entries({"state": self._states}, rows)

    def step(self, actions: ArrayLike) -> tuple[FloatArray, FloatArray, BoolArray, BoolArray, Info]:
        """Advance every row by one step, under actions [num_envs, m].

        Raises:
            ValueError: for actions of another shape, NaN or infinity.
            ResetNeeded: before the first reset, and where an ended row waits for one.
        """
        self._refuse_unstarted()
        moving = ~self._ended if self._mode is AutoresetMode.NEXT_STEP else self._all_rows()
        actions = checked_actions(actions, (self.num_envs, self.task.action_size))
        rewards, terminated, jacobians = self._move(moving, actions)
        truncated = moving & (self._elapsed >= self._limit)
        ended = terminated | truncated
        infos: Info = {}
        restarting = ~moving
        if self._mode is AutoresetMode.SAME_STEP:
            restarting = ended
            infos = self._last_words(jacobians, ended)
        self._start(restarting, self._drawn(restarting, [None] * self.num_envs))
        infos |= _entries({"state": self._states}, self._all_rows())
        infos |= _entries(jacobians, moving & ~restarting)
        self._ended = ended
        return self.task.features(self._states), rewards, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """The current states as images, or None without a render mode."""
        if self.render_mode is None:
            return None
        self._refuse_unstarted()
        return tuple(self.task.draw(state).rgb_array() for state in self._states)

    def _move(
        self, rows: BoolArray, actions: FloatArray
    ) -> tuple[FloatArray, BoolArray, dict[str, FloatArray]]:
        """Advance these rows; return rewards, ends and Jacobians of all rows, 0 in the others."""
        transition, found = move(self.task, self._states[rows], actions[rows], self._jacobians)
        self._states[rows] = transition.next_state
        self._elapsed[rows] += 1
        jacobians = {name: _spread(values, rows) for name, values in found.items()}
        return _spread(transition.reward, rows), _spread(transition.terminated, rows), jacobians

    def _start(self, rows: BoolArray, states: FloatArray) -> None:
        """Start episodes in these rows, from states [rows, n]."""
        self._states[rows] = states
        self._elapsed[rows] = 0
        self._ended[rows] = False

    def _drawn(self, rows: BoolArray, seeds: Sequence[int | None]) -> FloatArray:
        """The start states of these rows, from their seeds or the next seeds that they draw."""
        return self.task.initial_states(
            [first_seed(seeds[row], self._seeded[row][0]) for row in np.flatnonzero(rows).tolist()]
        )

    def _reseeded(self, rows: BoolArray, seeds: Sequence[int | None]) -> list[_Seeded]:
        """The generators of all rows, new ones for those of these rows that have a seed."""
        return [
            self._seeded[row] if seed is None or not chosen else seeding.np_random(seed)
            for row, (chosen, seed) in enumerate(zip(rows, seeds, strict=True))
        ]

    def _last_words(self, jacobians: Mapping[str, FloatArray], ended: BoolArray) -> Info:
        """The entries of `info` for episodes that ended in this step."""
        if not ended.any():
            return {}
        observations = np.full(self.num_envs, None, object)
        for row, observation in enumerate(self.task.features(self._states)):
            observations[row] = observation if ended[row] else None
        return {
            "final_obs": observations,
            "_final_obs": ended.copy(),
            "final_info": _entries({"state": self._states, **jacobians}, ended),
            "_final_info": ended.copy(),
        }

    def _refuse_unstarted(self) -> None:
        """Raise ResetNeeded before the first reset, and where ended rows wait for one."""
        if not self._is_started:
            raise ResetNeeded("call reset() first: no episode has been started")
        if self._mode is AutoresetMode.DISABLED and self._ended.any():
            raise ResetNeeded(
                f"the episodes of rows {np.flatnonzero(self._ended).tolist()} have ended: start "
                "new ones with reset(options={'reset_mask': mask}), or choose an autoreset_mode"
            )

    def _all_rows(self) -> BoolArray:
        return np.ones(self.num_envs, np.bool_)

    def _checked_mask(self, mask: Any) -> BoolArray:
        """The rows to reset: those of the mask, or all. For errors see `reset`."""
        if mask is None:
            return self._all_rows()
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise ValueError("options['reset_mask'] must be a numpy array of bool")
        if mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(
                f"options['reset_mask'] must have shape ({self.num_envs},) and at least one True, "
                f"not be {mask.tolist()}"
            )
        if not self._is_started and not mask.all():
            raise ResetNeeded(
                "the first reset must start every row, but reset_mask leaves some out"
            )
        return mask.copy()

    def _checked_seeds(self, seed: Seeds) -> Sequence[int | None]:
        """A seed or None for each row. For errors see `reset`."""
        if seed is None or isinstance(seed, int):
            return [None if seed is None else seed + row for row in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"there must be {self.num_envs} seeds, one a row, not {len(seed)}")
        return seed


def _spread(values: NDArray[Any], rows: BoolArray) -> NDArray[Any]:
    """Values of these rows as an array of all rows, 0 in the others."""
    spread = np.zeros((len(rows), *values.shape[1:]), values.dtype)
    spread[rows] = values
    return spread


def _entries(arrays: Mapping[str, NDArray[Any]], rows: BoolArray) -> Info:
    """Arrays of all rows as entries of `info` for these rows alone; none if there are no rows."""
    if not rows.any():
        return {}
    entries = {name: _spread(array[rows], rows) for name, array in arrays.items()}
    return entries | {f"_{name}": rows.copy() for name in arrays}


def _time_limit(steps: int | None, horizon: int) -> int:
    """The number of steps after which an episode is truncated."""
    if steps is None:
        return horizon
    return np.iinfo(np.int64).max if steps == -1 else _at_least_one(steps, "max_episode_steps")


def _at_least_one(number: int, what: str) -> int:
    """`number` as an integer. Raises ValueError below 1."""
    whole = operator.index(number)
    if whole < 1:
        raise ValueError(f"{what} must be a whole number from 1 on, not {number}")
    return whole
