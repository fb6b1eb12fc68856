"""NoisyTask: a task with noise (noise.py), made of the task without noise.

    s = (the task's coordinates, stream, step)

A step is that of the task from the disturbed state: its reward, its end and its derivatives are
those of that state. So code that plays, learns, saves or differentiates a task treats this one
alike. The two coordinates of the place in the noise are hidden from networks, and nothing depends
smoothly on them: their rows and columns of the Jacobian are 0.
"""

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from array_api_compat import array_namespace
from numpy.typing import NDArray

from physics.domain import DomainError
from physics.features import Array
from physics.noise import (
    OBSERVATION,
    PLACE,
    PROCESS,
    STREAMS,
    first_place,
    next_places,
    normal,
)

if TYPE_CHECKING:
    from physics.drawing import Drawing
    from physics.environment import Environment, ParameterDerivatives, Pieces

FloatArray = NDArray[np.float64]

TAKEN_OVER = (
    "name",
    "version",
    "action_size",
    "horizon",
    "max_reward",
    "step_seconds",
    "reward_is_differentiable",
    "angles",
    "clipped",
    "feature_order",
    "noise_factors",
    "rounding",
    "tolerance",
    "regimes",
)
"""Constants that noise does not change."""
SAMPLED = 1_000
"""The number of streams, and of steps in each, over which an audit's states are spread."""


class NoisyTask:
    """The methods of a task that differ with noise; a base of `NoisyEnvironment`.

    Attributes:
        task: the task without noise; its `changed` has the values of the noise.
    """

    def __init__(self, task: "Environment", process: float, observation: float) -> None:
        """Take over the task's constants.

        Args:
            task: the task without noise.
            process: the standard deviation of process noise.
            observation: the standard deviation of observation noise.
        """
        n = task.state_size
        self.task = task
        self._deviations = process, observation
        self._factors = np.array([task.noise_factors.get(i, 1.0) for i in range(n)])
        limits = (task.bounds.get(i, (-np.inf, np.inf)) for i in range(n))
        self._lowest, self._highest = np.array(list(limits)).T
        places = dict.fromkeys((n, n + 1), (0.0, float(STREAMS)))
        constants = {name: getattr(task, name) for name in TAKEN_OVER} | {
            "changed": task.changed,
            "state_size": n + PLACE,
            "hidden": (*task.hidden, n, n + 1),
            "bounds": {**task.bounds, **places},
        }
        for name, value in constants.items():
            setattr(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle only the arguments of its constructor."""
        return type(self), (self.task, *self._deviations)

    @property
    def process_noise(self) -> float:
        """The standard deviation of the noise that moves a state before a step."""
        return self._deviations[0]

    @property
    def observation_noise(self) -> float:
        """The standard deviation of the noise in the observed coordinates."""
        return self._deviations[1]

    @property
    def parameters(self) -> dict[str, float]:
        """The values of the task's physical parameters."""
        return self.task.parameters

    def with_parameters(self, **values: float) -> Any:
        """See `Environment.with_parameters`."""
        return self.task.with_parameters(**values)

    def without_noise(self) -> "Environment":
        """See `Environment.without_noise`."""
        return cast("Environment", type(self)(self.task, 0.0, 0.0))

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Draw a start state of the task, and a stream of noise at its first step."""
        return np.concatenate([self.task.initial_state(generator), first_place(generator)])

    def step_kernel(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray, *rest: Any
    ) -> int:
        """Step every row; see `Environment.step_kernel`."""
        following, n = np.empty((len(states), self._n)), self._n
        unsolved = self.task.step_kernel(self._allowed(states, actions), actions, following, *rest)
        next_states[:, :n], next_states[:, n:] = following, next_places(states[:, n:])
        return unsolved

    def differentiate_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: NDArray[np.bool_],
        state_jacobians: FloatArray,
        action_jacobians: FloatArray,
        reward_state_gradients: FloatArray,
        reward_action_gradients: FloatArray,
        reward_next_state_gradients: FloatArray,
    ) -> int:
        """Step and differentiate every row; see `Environment.differentiate_kernel`."""
        batch, n = len(states), self._n
        following, J_s = np.empty((batch, n)), np.empty((batch, n, n))
        J_a, r_s, r_next = np.empty((batch, n, self.task.action_size)), *np.empty((2, batch, n))
        unsolved = self.task.differentiate_kernel(
            self._allowed(states, actions), actions, following, rewards, terminated,
            J_s, J_a, r_s, reward_action_gradients, r_next,
        )  # fmt: skip
        within = self.sides(states) == 0
        next_states[:, :n], next_states[:, n:] = following, next_places(states[:, n:])
        for whole, part in (
            (state_jacobians[:, :n, :n], J_s * within[:, None]),
            (action_jacobians[:, :n], J_a),
            (reward_state_gradients[:, :n], r_s * within),
            (reward_next_state_gradients[:, :n], r_next),
        ):
            whole[:] = part
        for of_places in (
            state_jacobians[:, n:],
            state_jacobians[:, :n, n:],
            action_jacobians[:, n:],
            reward_state_gradients[:, n:],
            reward_next_state_gradients[:, n:],
        ):
            of_places[:] = 0.0
        return unsolved

    def differentiate_parameters(
        self, states: FloatArray, actions: FloatArray
    ) -> "ParameterDerivatives":
        """The derivatives of one step in the task's physical parameters."""
        found = self.task.differentiate_parameters(self.disturbed(states), actions)
        of_places = np.zeros((len(states), PLACE, found.next_state.shape[2]))
        return found._replace(next_state=np.concatenate([found.next_state, of_places], axis=1))

    def features(self, states: Array) -> Array:
        """The features of states [batch, n + 2], with the noise of their places added."""
        if states.shape[-1] != self._n + PLACE:
            raise ValueError(
                f"states must be [batch, {self._n + PLACE}], the last two the place in the noise "
                f"(stream, step), not {list(states.shape)}"
            )
        seen = states[..., : self._n]
        if self.observation_noise:
            told = states.detach() if hasattr(states, "detach") else states
            xp, places = array_namespace(states), np.asarray(told[..., self._n :])
            numbers = self.observation_noise * normal(OBSERVATION, places, self._n)
            seen = seen + xp.asarray(numbers, dtype=states.dtype)
        return self.task.features(cast("Array", seen))

    def feature_slopes(self, features: Array) -> Array:
        """See `Environment.feature_slopes`."""
        return self.task.feature_slopes(features)

    def outside(self, states: FloatArray) -> NDArray[np.bool_]:
        """Which states [batch] are outside the domain of the task or of the places."""
        beyond: NDArray[np.bool_] = self.task.outside(self._own(states))
        return beyond | super().outside(states)  # type: ignore[misc,no-any-return]

    def check_inside(self, states: FloatArray, actions: FloatArray) -> None:
        """See `Environment.check_inside`."""
        super().check_inside(states, actions)  # type: ignore[misc]
        self.task.check_inside(self._own(states), actions)

    def pieces(self, states: FloatArray, actions: FloatArray) -> "Pieces":
        """The pieces of the disturbed states, and which coordinates the noise clips to a bound."""
        found = self.task.pieces(self.disturbed(states), actions)
        bounded = sorted(self.task.bounds)
        sides = self.sides(states)[:, bounded]
        return found._replace(piece=np.concatenate([found.piece, sides], axis=1))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """The task's states, each at its own place in the noise."""
        states, actions = self.task.sample(generator, count)
        places = generator.integers(1, SAMPLED, (len(states), PLACE))
        return np.concatenate([states, places], axis=1), actions

    def draw(self, state: FloatArray) -> "Drawing":
        """The state as it is, not as it is observed."""
        return self.task.draw(state[: self._n])

    def contact_impulses(self, states: FloatArray, actions: FloatArray) -> list[FloatArray]:
        """See `Environment.contact_impulses`."""
        return self.task.contact_impulses(self.disturbed(states), actions)

    def remarks(self, states: FloatArray, actions: FloatArray) -> list[str]:
        """The remarks of the task, and a note on its derivatives."""
        numbers = (
            f"process noise {self.process_noise:g}, observation noise {self.observation_noise:g}"
        )
        return [
            *self.task.remarks(self.disturbed(states), actions),
            f"{numbers}: the derivatives compared are those of steps at the noise drawn; the "
            "differences use the same noise.",
        ]

    def compile(self) -> float:
        """See `Environment.compile`."""
        return self.task.compile()

    def failure(self, state: FloatArray, action: FloatArray) -> Exception:
        """The error for the disturbed state."""
        return self.task.failure(self.disturbed(state[None])[0], action)

    def disturbed(self, states: FloatArray) -> FloatArray:
        """The disturbed states [batch, n] of the task, from which steps of [batch, n + 2] start."""
        if not self.process_noise:
            return self._own(states)
        held: FloatArray = np.minimum(np.maximum(self._moved(states), self._lowest), self._highest)
        return held

    def sides(self, states: FloatArray) -> NDArray[np.int64]:
        """-1, 0 or 1 [batch, n]: whether the noise moves it below, within or above its bounds."""
        if not self.process_noise:
            return np.zeros((len(states), self._n), np.int64)
        moved = self._moved(states)
        sides: NDArray[np.int64] = (moved > self._highest).astype(np.int64) - (moved < self._lowest)
        return sides

    def process_numbers(self, places: FloatArray) -> FloatArray:
        """The process noise [batch, n] of these places, for a deviation of 1."""
        numbers: FloatArray = normal(PROCESS, places, self._n) * self._factors
        return numbers

    @property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """The least and greatest values of a disturbed state: [n] and [n]."""
        return self._lowest, self._highest

    @property
    def _n(self) -> int:
        """The coordinates of the task without noise."""
        return self.task.state_size

    def _own(self, states: FloatArray) -> FloatArray:
        """The task's coordinates, contiguous."""
        return np.ascontiguousarray(states[:, : self._n])

    def _moved(self, states: FloatArray) -> FloatArray:
        """The states with their noise, before they are clipped to the bounds."""
        numbers = self.process_numbers(states[:, self._n :])
        moved: FloatArray = states[:, : self._n] + self.process_noise * numbers
        return moved

    def _allowed(self, states: FloatArray, actions: FloatArray) -> FloatArray:
        """The disturbed states, if steps may start there."""
        disturbed = self.disturbed(states)
        try:
            self.task.check_inside(disturbed, actions)
        except DomainError as error:
            raise DomainError(
                f"{error}; process noise moved it there: give the coordinates that it must not "
                "move a factor of 0 in the task's noise_factors",
                error.rows,
            ) from error
        return disturbed
