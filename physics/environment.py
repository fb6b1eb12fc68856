"""Environment: the interface of every task.

One transition is a pure function of state and action, computed for a whole batch at once:

    s' = f(s, clip(a, -1, 1)),    r = r(s, clip(a, -1, 1), s'),    terminated = whether s' ends it

with the exact derivatives on request. Every row is computed by itself: its bits do not depend on
the other rows. A task is a subclass that declares its sizes, constants and regimes, and defines two
kernels, a start state and a drawing.

Derivatives at bounds. Outside the box `[-1, 1]` an action's derivative is 0. At `|a| = 1` exactly
it is the interior derivative: a tanh policy reaches 1.0 in floating point, and must still be able
to learn to leave the bound. Every other clip follows the same rule: at the bound itself, its
derivative is the interior one. The derivative of a wrapped angle is 1.

Glossary:
    s, s'   state and next state, float64 [batch, n], in intrinsic coordinates (never features)
    a       action, float64 [batch, m]
    r       reward, float64 [batch]
"""

import time
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from physics.domain import Domain
from physics.domain import DomainError as DomainError  # noqa: PLC0414 - part of this interface
from physics.domain import NotFiniteError as NotFiniteError  # noqa: PLC0414
from physics.drawing import Drawing
from physics.exploration import explore
from physics.features import Array, FeatureMap
from physics.noise import OBSERVATION, PARAMETERS, PROCESS, is_noisy
from physics.noisy_task import NoisyTask
from physics.parameter import checked, declared, label
from physics.parameter_differences import by_differences
from physics.randomness import generator
from physics.row_checks import (
    are_finite,
    float64_rows,
    float64_vector,
    is_finite_linearization,
)
from physics.task_check import CheckedWhenMade

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

BOOL = np.dtype(np.bool_)


class Transition(NamedTuple):
    """One step of each row of a batch."""

    next_state: FloatArray
    """[batch, n]"""
    reward: FloatArray
    """[batch]"""
    terminated: BoolArray
    """[batch]; a time limit does not count as termination."""


class Linearization(NamedTuple):
    """One step of each row of a batch, with its exact derivatives."""

    transition: Transition
    """The step itself, bit for bit as `Environment.step` returns it."""
    state_jacobian: FloatArray
    """[batch, n, n], `J[i, j] = d next_state_i / d state_j`."""
    action_jacobian: FloatArray
    """[batch, n, m], `J[i, j] = d next_state_i / d action_j`."""
    reward_state_gradient: FloatArray
    """[batch, n], partial derivative of `r(s, a, s')` in s, with s' held."""
    reward_action_gradient: FloatArray
    """[batch, m], partial derivative in a, with s' held."""
    reward_next_state_gradient: FloatArray
    """[batch, n], partial derivative in s'."""


class Pieces(NamedTuple):
    """On which smooth piece of its map each step of a batch lies (see `Environment.pieces`)."""

    regime: IntArray
    """[batch], index into the task's `regimes`."""
    piece: IntArray
    """[batch, k]: two steps lie on the same smooth piece if and only if their rows are equal."""


class ParameterDerivatives(NamedTuple):
    """The derivatives of one step of each row of a batch in the task's k parameters."""

    next_state: FloatArray
    """[batch, n, k], `d next_state_i / d parameter_j`."""
    reward: FloatArray
    """[batch, k], partial derivative of `r(s, a, s')`, with s' held."""


class UnsolvedStepError(ArithmeticError):
    """A step whose equations could not be solved; its message holds the state and the action."""


class Environment(metaclass=CheckedWhenMade):
    """A task: its constants, dynamics, derivatives and features.

    An instance holds no state: all its methods are pure.
    """

    name: ClassVar[str]
    """The name that users write, and that its entry point has."""
    version: ClassVar[int]
    """To be raised whenever the task's numbers change; stored with results."""
    state_size: ClassVar[int]
    """n, the coordinates of a state."""
    action_size: ClassVar[int]
    """m, the components of an action."""
    horizon: ClassVar[int]
    """Steps after which an episode is truncated."""
    max_reward: ClassVar[float]
    """The `max(r)` of the normalised return."""
    step_seconds: ClassVar[float] = 1 / 30
    """Seconds of a step when an episode is played; the default is for tasks without a time unit."""
    reward_is_differentiable: ClassVar[bool] = True
    """If False, the reward is piecewise constant and its gradients are 0."""
    angles: ClassVar[Mapping[int, int]] = MappingProxyType({})
    """Coordinate -> multiplicity k: the network sees `cos(k theta), sin(k theta)`."""
    hidden: ClassVar[tuple[int, ...]] = ()
    """Coordinates that no network sees."""
    clipped: ClassVar[Mapping[int, float]] = MappingProxyType({})
    """Coordinate -> limit: the network sees it clipped to `[-limit, limit]`. The step does not."""
    feature_order: ClassVar[tuple[int, ...]] = ()
    """The order of the features, each by its index in the order of the coordinates; empty for the
    order of the coordinates."""
    bounds: ClassVar[Mapping[int, tuple[float, float]]] = MappingProxyType({})
    """Coordinate -> its least and greatest value: no step starts or ends beyond them."""
    noise_factors: ClassVar[Mapping[int, float]] = MappingProxyType({})
    """Coordinate -> factor of its process noise, 1 by default; 0 for constants, and for coordinates
    that must not move before a step, such as those at a contact."""
    rounding: ClassVar[float] = 1e-15
    """How far rounding moves the numbers of a step: a difference is uncertain by this over its
    width. The default is for numbers of order 1 to 10 that nothing amplifies."""
    tolerance: ClassVar[float] = 1e-6
    """The largest error that the gradient audit accepts; larger for derivatives by differences."""
    regimes: ClassVar[tuple[str, ...]] = ("free", "clipped")
    """The kinds of step that the gradient audit reports separately."""

    step_kernel: Callable[..., int]
    """`(s, a, *transition)` fills the transition's arrays and returns -1, or the first row that
    has no solution."""
    differentiate_kernel: Callable[..., int]
    """`(s, a, *transition, *derivatives)` does the same with all fields of a Linearization."""
    parameter_kernel: Callable[..., None] | None = None
    """`(s, a, *derivatives)` fills ParameterDerivatives, which are 0 before; None: differences."""

    changed: Mapping[str, Any] = MappingProxyType({})
    """The values of the parameters that were given, by name; they may equal the defaults."""

    def with_parameters(self, **values: float) -> Self:
        """The same task with these values of its parameters; the others stay as they are.

        Every task has `process_noise` and `observation_noise` (noise.py). Where one of them is not
        0, the task is a `NoisyEnvironment`, and its state has two more coordinates.

        Raises:
            ValueError: for every name that is not a parameter and every value out of its range.
        """
        known = [*declared(type(self)).values(), *PARAMETERS]
        task = self._changed(checked(self.name, known, values))
        if not is_noisy(task.changed):
            return task
        noisy: Any = NoisyEnvironment(task, task.process_noise, task.observation_noise)
        with_noise: Self = noisy  # the same type, for callers that give no noise
        return with_noise

    def without_noise(self) -> "Environment":
        """The task on the same states, without noise; planners use it."""
        return self

    @property
    def process_noise(self) -> float:
        """The standard deviation of the noise that moves a state before a step."""
        return float(self.changed.get(PROCESS, 0.0))

    @property
    def observation_noise(self) -> float:
        """The standard deviation of the noise in the observed coordinates."""
        return float(self.changed.get(OBSERVATION, 0.0))

    @property
    def parameters(self) -> dict[str, float]:
        """The values of all physical parameters, by name, in the order of their declaration."""
        return {name: getattr(self, name) for name in declared(type(self))}

    @property
    def label(self) -> str:
        """The name, and the values of the parameters that were given: `Pendulum(gravity=9.81)`."""
        return label(self.name, self.changed)

    def _changed(self, values: Mapping[str, Any]) -> Self:
        """A copy with these values, floats or tensors."""
        other = copy(self)
        other.changed = {**self.changed, **values}
        return other

    def __getstate__(self) -> dict[str, Any]:
        """The attributes that a copy takes over: all but the cached properties."""
        return {
            name: value
            for name, value in vars(self).items()
            if not isinstance(getattr(type(self), name, None), cached_property)
        }

    @cached_property
    def parameter_values(self) -> FloatArray:
        """The values of all parameters [k], in the order in which they are declared."""
        return np.array(list(self.parameters.values()), np.float64)

    @cached_property
    def feature_map(self) -> FeatureMap:
        """The map from states to features."""
        return FeatureMap(
            self.state_size, self.angles, self.hidden, self.clipped, self.feature_order
        )

    @cached_property
    def _domain(self) -> Domain:
        return Domain(self.name, self.state_size, self.bounds)

    @abstractmethod
    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Draw one start state [n]."""

    @abstractmethod
    def draw(self, state: FloatArray) -> Drawing:
        """Draw one state [n]."""

    def step(self, states: FloatArray, actions: FloatArray) -> Transition:
        """Advance states [batch, n] by one step under actions [batch, m].

        Raises:
            ValueError: for a wrong type, dtype or shape.
            DomainError: for states outside the task's domain.
            NotFiniteError: for NaN and infinity in states and actions, or in the step's results.
            UnsolvedStepError: when a row's equations have no solution within the solver's bounds.
        """
        # Written out: for small batches, one more call and an unpacked tuple are a tenth of a step.
        states, actions = self._checked(states, actions)
        batch = len(states)
        next_state, reward = np.empty((batch, self.state_size)), np.empty(batch)
        terminated = np.empty(batch, BOOL)
        unsolved = self.step_kernel(states, actions, next_state, reward, terminated)
        if unsolved >= 0:
            raise self.failure(states[unsolved], actions[unsolved])
        transition = Transition(next_state, reward, terminated)
        if not are_finite(next_state, reward):
            raise self._not_finite(states, actions, transition._asdict())
        return transition

    def differentiate(self, states: FloatArray, actions: FloatArray) -> Linearization:
        """Advance by one step, bit for bit as `step`, with the exact derivatives.

        Raises:
            ValueError, DomainError, NotFiniteError, UnsolvedStepError: as `step`.
        """
        states, actions = self._checked(states, actions)
        batch, n, m = len(states), self.state_size, self.action_size
        transition = np.empty((batch, n)), np.empty(batch), np.empty(batch, BOOL)
        derivatives = (
            np.empty((batch, n, n)),
            np.empty((batch, n, m)),
            np.empty((batch, n)),
            np.empty((batch, m)),
            np.empty((batch, n)),
        )
        unsolved = self.differentiate_kernel(states, actions, *transition, *derivatives)
        if unsolved >= 0:
            raise self.failure(states[unsolved], actions[unsolved])
        linearization = Linearization(Transition(*transition), *derivatives)
        if not is_finite_linearization(transition[0], transition[1], *derivatives):
            quantities = {**linearization.transition._asdict(), **linearization._asdict()}
            del quantities["transition"]
            raise self._not_finite(states, actions, quantities)
        return linearization

    def differentiate_parameters(
        self, states: FloatArray, actions: FloatArray
    ) -> ParameterDerivatives:
        """The derivatives of one step in the parameters; `torch_step` uses them.

        They are differences where the task has no `parameter_kernel` (parameter_differences.py).

        Raises:
            ValueError, DomainError, NotFiniteError, UnsolvedStepError: as `step`.
        """
        states, actions = self._checked(states, actions)
        kernel = self.parameter_kernel
        if kernel is None:
            by_next = self.differentiate(states, actions).reward_next_state_gradient
            following, total = by_differences(self, states, actions)
            return ParameterDerivatives(
                following, total - np.einsum("bi,bij->bj", by_next, following)
            )
        batch, k = len(states), len(self.parameter_values)
        found = ParameterDerivatives(np.zeros((batch, self.state_size, k)), np.zeros((batch, k)))
        kernel(states, actions, *found)
        return found

    def initial_states(self, seeds: Sequence[int] | IntArray) -> FloatArray:
        """Start states [len(seeds), n]; row i depends on `seeds[i]` alone.

        Raises:
            ValueError: for a seed that is not an integer from 0 on, and for a start state outside
                the task's domain.
        """
        states = np.empty((len(seeds), self.state_size))
        for row, seed in enumerate(seeds):
            state = self.initial_state(generator(seed, "initial state"))
            states[row] = float64_vector(state, self.state_size, f"{self.name}: an initial state")
        self.check_inside(states, np.empty((len(seeds), 0)))
        return states

    def outside(self, states: FloatArray) -> BoolArray:
        """Which states [batch] are outside the task's domain: beyond `bounds`, except for rounding.

        A task whose domain has another shape overrides this and `check_inside`.
        """
        return self._domain.outside(states)

    def check_inside(self, states: FloatArray, actions: FloatArray) -> None:
        """Refuse rows from which no step may start.

        Raises:
            NotFiniteError, DomainError: as `step`.
        """
        self._domain.check(states, actions)

    def remarks(self, states: FloatArray, actions: FloatArray) -> list[str]:
        """Further notes for the audit of the task, from a sample of states and actions."""
        del states, actions
        return []

    def function_mistakes(self) -> list[str]:
        """The mistakes in the task's functions, one sentence each; checked when it is made."""
        return []

    def features(self, states: Array) -> Array:
        """The features [batch, F] of states [batch, n], numpy or torch (differentiable)."""
        return self.feature_map.features(states)

    def feature_slopes(self, features: Array) -> Array:
        """`d feature_i / d state[feature_sources[i]]` [batch, F], from the features themselves."""
        return self.feature_map.slopes(features)

    @property
    def feature_size(self) -> int:
        """F, how many features a network sees."""
        return self.feature_map.size

    @property
    def feature_sources(self) -> IntArray:
        """[F], the one coordinate that each feature depends on."""
        return self.feature_map.sources

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """The smooth piece of the map on which each step lies; the audit compares within one.

        A task with more kinks than the action's clip (walls, wraps, contacts) overrides this.
        """
        beyond = clip_sides(actions)
        del states
        return Pieces(regime=np.any(beyond, axis=1).astype(np.int64), piece=beyond)

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """States [count, n] and actions [count, m] that reach every regime, for the audit.

        By default, the states are those that random, bang-bang and constant actions reach, and a
        sixth of the actions lie outside the box.
        """
        return explore(self, generator, count)

    def contact_impulses(self, states: FloatArray, actions: FloatArray) -> list[FloatArray]:
        """The impulses of the contacts during each row's step, for drawings.

        One array [k, 4] a row, `(x, y, px, py)`: the position of a contact in the drawing, in
        metres, and its impulse on the moving body, in N s. By default a task has no contacts.

        Raises:
            ValueError, UnsolvedStepError: as `step`.
        """
        states, actions = self._checked(states, actions)
        return [np.empty((0, 4)) for _ in states]

    def compile(self) -> float:
        """Compile every kernel, or load it from the cache; return the seconds that this took.

        Without this call, the first `step` and the first `differentiate` do the same.
        """
        start = time.perf_counter()
        states, actions = np.empty((0, self.state_size)), np.empty((0, self.action_size))
        self.step(states, actions)
        self.differentiate(states, actions)
        self.features(states)
        return time.perf_counter() - start

    def failure(self, state: FloatArray, action: FloatArray) -> Exception:
        """The error for a row that the kernels could not solve; a task may override it."""
        return UnsolvedStepError(
            f"{self.name}: no solution for state {state.tolist()}, action {action.tolist()}"
        )

    def _not_finite(
        self, states: FloatArray, actions: FloatArray, quantities: Mapping[str, NDArray[Any]]
    ) -> NotFiniteError:
        """The error for the rows in which a quantity [batch, ...] is NaN or infinite."""
        wrong = {name: ~np.isfinite(array) for name, array in quantities.items()}
        by_row = {name: each.reshape(len(each), -1).any(axis=1) for name, each in wrong.items()}
        rows = np.flatnonzero(np.any(list(by_row.values()), axis=0))
        row = int(rows[0])
        name = next(name for name, each in by_row.items() if each[row])
        place = np.argwhere(wrong[name][row])[0].tolist()
        value = quantities[name][row][tuple(place)]
        return NotFiniteError(
            f"{self.name}: {name}{place or ''} of row {row} is {value}, "
            f"for state {states[row].tolist()}, action {actions[row].tolist()}",
            rows,
            name.replace("_", " "),
        )

    def _checked(self, states: FloatArray, actions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Both arrays as the kernels take them, within the domain. Raises ValueError otherwise."""
        states, actions = self._rows(states, actions)
        self.check_inside(states, actions)
        return states, actions

    def _rows(self, states: FloatArray, actions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Both arrays as the kernels were compiled for. Raises ValueError otherwise."""
        states = float64_rows(states, self.state_size, "states")
        actions = float64_rows(actions, self.action_size, "actions")
        if len(states) != len(actions):
            raise ValueError(
                "states and actions must have the same number of rows, "
                f"not {len(states)} and {len(actions)}"
            )
        return states, actions


class NoisyEnvironment(NoisyTask, Environment):
    """A task with noise; see noisy_task.py."""


def clip_sides(actions: FloatArray) -> IntArray:
    """-1, 0 or 1 [batch, m]: below, within or above the box `[-1, 1]`."""
    return (actions > 1.0).astype(np.int64) - (actions < -1.0)
