"""Windows: some steps of all the environments of each run; episodes may end and begin in them.

Each run has E environments, whose episodes are numbered as they begin: episode i starts in the
state drawn from the generator of (seed, "episode", i). A window continues where the one before
ended. A time limit truncates: the episode ends, but the task has not.

Glossary: `T` steps of a window, `E` environments of a run, `K` runs; `n`, `m`, `F` sizes of states,
actions and features.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.experience.rollout import start_states
from algorithms.failing_rows import Failures, call_rows
from algorithms.state import State, fill
from physics.environment import Environment, Linearization, Transition

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Window(NamedTuple):
    """The steps of one run."""

    features: Floats
    """[T, E, F]"""
    noise: NDArray[np.float32]
    """[T, E, m], the noise that was added to the actor's means."""
    rewards: Floats
    """[T, E]"""
    next_features: Floats
    """[T, E, F], of the states that steps led to, before other episodes begin."""
    terminated: Bools
    """[T, E]"""
    is_last: Bools
    """[T, E], whether its episode or the window ends with the step."""
    derivatives: tuple[Floats, ...]
    """[T, E, ...] each, in the order of a `physics` Linearization; empty if not needed."""


def of_run(windows: Window, k: int, environments: int) -> Window:
    """The window of run k, contiguous, from the window of all runs, [T, K E, ...] each."""
    mine = slice(k * environments, (k + 1) * environments)
    parts: Sequence[NDArray[Any]] = windows[:-1]
    own = (np.ascontiguousarray(part[:, mine]) for part in parts)
    derivatives = (np.ascontiguousarray(part[:, mine]) for part in windows.derivatives)
    return Window._make([*own, tuple(derivatives)])


class Episodes:
    """The ongoing episodes of one run.

    Attributes:
        states: [E, n].
        elapsed: steps of each so far [E].
        is_over: [E], whether another episode must begin first.
    """

    def __init__(self, seed: int, environments: int, state_size: int) -> None:
        """Begin without episodes."""
        self.states = np.zeros((environments, state_size))
        self.elapsed = np.zeros(environments, np.int64)
        self.is_over = np.ones(environments, np.bool_)
        self._seed = seed
        self._begun = 0

    def next_start(self) -> tuple[int, str, int]:
        """The next episode's argument of `start_states`."""
        self._begun += 1
        return self._seed, "episode", self._begun - 1

    def state(self) -> State:
        """Its state, without the seed."""
        return {
            "states": self.states,
            "elapsed": self.elapsed,
            "is_over": self.is_over,
            "begun": np.array(self._begun),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        fill(self.states, state["states"])
        fill(self.elapsed, state["elapsed"])
        fill(self.is_over, state["is_over"])
        self._begun = int(state["begun"])


class _Columns:
    """The ongoing episodes of K runs, side by side."""

    def __init__(self, environment: Environment, episodes: Sequence[Episodes]) -> None:
        self.states = np.concatenate([one.states for one in episodes])
        self.elapsed = np.concatenate([one.elapsed for one in episodes])
        self.is_over = np.concatenate([one.is_over for one in episodes])
        self._environment = environment
        self._episodes = episodes
        self._each = len(episodes[0].states)

    def begin(self) -> Failures:
        """Begin another episode where one is over; return the failures by column."""
        over = np.flatnonzero(self.is_over).tolist()
        if not over:
            return {}
        purposes = [self._episodes[column // self._each].next_start() for column in over]
        self.states[over], unborn = start_states(self._environment, purposes)
        self.elapsed[over] = 0
        return {over[i]: error for i, error in unborn.items()}

    def go_on(self, transition: Transition) -> None:
        """Move on by a step."""
        self.elapsed += 1
        self.states = transition.next_state.copy()
        self.is_over = transition.terminated | (self.elapsed >= self._environment.horizon)

    def leave(self) -> None:
        """Store the state of the episodes in the runs."""
        for k, one in enumerate(self._episodes):
            mine = slice(k * self._each, (k + 1) * self._each)
            one.states[:] = self.states[mine]
            one.elapsed[:] = self.elapsed[mine]
            one.is_over[:] = self.is_over[mine]


def live(
    environment: Environment,
    episodes: Sequence[Episodes],
    act: Callable[[Floats, int], Floats],
    noise: NDArray[np.float32],
    *,
    linearized: bool,
) -> tuple[Window | None, Failures]:
    """Take steps in the environments of K runs.

    Args:
        environment: the task.
        episodes: those of each run; they are advanced.
        act: a function that returns the actions [K E, m] for features [K E, F] at step t.
        noise: the noise that `act` adds to the actors' means [T, K E, m].
        linearized: whether to compute the steps' derivatives.

    Returns:
        The window, [T, K E, ...], void for columns that failed, None if all did; and the failures,
        by column.
    """
    advance: Callable[..., Transition | Linearization] = (
        environment.differentiate if linearized else environment.step
    )
    columns = _Columns(environment, episodes)
    rows: list[tuple[NDArray[Any], ...]] = []
    failures: Failures = {}
    for t in range(len(noise)):
        failures = columns.begin() | failures
        features = environment.features(columns.states)
        steps, failed = call_rows(advance, columns.states, act(features, t))
        failures = failed | failures
        if steps is None:
            return None, failures
        transition, derivatives = _taken(steps)
        columns.go_on(transition)
        next_features = environment.features(columns.states)
        is_last = columns.is_over | (t == len(noise) - 1)
        rows.append((
            features, transition.reward, next_features, transition.terminated, is_last,
            *derivatives,
        ))  # fmt: skip
    columns.leave()
    features, *others = (np.stack(part) for part in zip(*rows, strict=True))
    rewards, next_features, terminated, is_last, *stacked = others
    return (
        Window(features, noise, rewards, next_features, terminated, is_last, tuple(stacked)),
        failures,
    )


def _taken(steps: Transition | Linearization) -> tuple[Transition, tuple[Floats, ...]]:
    """The transitions, and their derivatives if there are any."""
    if isinstance(steps, Transition):
        return steps, ()
    transition, *derivatives = steps
    return transition, tuple(derivatives)


def check_finite(window: Window) -> None:
    """Refuse rewards and features beyond float32, which networks cannot learn from.

    Raises:
        NotFiniteQuantityError: with the name of the first.
    """
    largest = np.finfo(np.float32).max
    for name, part in (("rewards", window.rewards), ("features", window.features)):
        if not (np.abs(part) <= largest).all():
            raise NotFiniteQuantityError(name)
