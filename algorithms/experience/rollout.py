"""Rollout: the ongoing episodes of a cohort, stepped together.

Each run's episodes have their own start states: that of episode i is drawn from the generator of
(seed, "episode", i). A time limit truncates: the episode ends, but the task has not.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.experience.replay import Memory, empty_memory
from algorithms.experience.target_jacobian import fold
from algorithms.failing_rows import Failures, call_rows, failures_of
from algorithms.networks.policy import Policies
from algorithms.networks.scaling import Coordinates
from algorithms.state import State
from physics.environment import Environment, Linearization, Transition
from physics.randomness import generator

FloatArray = NDArray[np.float64]


class Experience(NamedTuple):
    """Some steps of one run, in order."""

    transitions: Memory
    states: FloatArray
    """[steps, n]"""


def start_states(
    environment: Environment, purposes: Sequence[tuple[int, str, int]]
) -> tuple[FloatArray, Failures]:
    """A start state for each (seed, purpose, index), void where drawing it failed; the failures."""
    seeds = np.array([generator(*purpose).integers(2**63) for purpose in purposes], np.int64)
    states, failures = call_rows(environment.initial_states, seeds)
    return np.zeros((len(seeds), environment.state_size)) if states is None else states, failures


class Rollout:
    """The episodes of K runs.

    Attributes:
        episodes: int [K], how many episodes each run has ended.
    """

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seeds: Sequence[int],
        *,
        linearized: bool,
        time_limit_is_terminal: bool,
    ) -> None:
        """Start the first episode of each run.

        Args:
            environment: the task.
            coordinates: the coordinates of its features.
            seeds: the seeds of the runs.
            linearized: whether to compute each step's derivatives.
            time_limit_is_terminal: whether a time limit counts as the task's end.
        """
        self._environment = environment
        self._coordinates = coordinates
        self._linearized = linearized
        self._time_limit_is_terminal = time_limit_is_terminal
        self._seeds = list(seeds)
        self.episodes = np.zeros(len(seeds), np.int64)
        self._elapsed = np.zeros(len(seeds), np.int64)
        self._states, self._failures = start_states(
            environment, [(seed, "episode", 0) for seed in seeds]
        )

    def keep(self, rows: Sequence[int]) -> None:
        """Keep these runs only."""
        kept = list(rows)
        self._seeds = [self._seeds[row] for row in kept]
        self.episodes = self.episodes[kept]
        self._elapsed = self._elapsed[kept]
        self._states = self._states[kept]
        self._failures = failures_of(self._failures, kept)

    def state(self, k: int) -> State:
        """The number of run k's episode, its elapsed steps and its state."""
        return {
            "episodes": np.array(self.episodes[k]),
            "elapsed": np.array(self._elapsed[k]),
            "state": self._states[k],
        }

    def restore(self, k: int, state: State) -> None:
        """Restore what `state` returned."""
        self.episodes[k] = state["episodes"]
        self._elapsed[k] = state["elapsed"]
        self._states[k] = state["state"]

    def work_out(self, journal: State) -> Memory:
        """The transitions of a replay's journal, with the same bits as originally."""
        states, actions = journal["states"], journal["actions"]
        lived = self._empty(len(states))
        lived.features[:] = self._environment.features(states)
        lived.actions[:] = actions
        steps = self._advance(states, actions.astype(np.float64))
        transition = self._note(steps, slice(None), lived)
        lived.rewards[:] = transition.reward
        lived.next_features[:] = self._environment.features(transition.next_state)
        lived.continues[:] = journal["continues"]
        return lived

    def collect(
        self, steps: int, policies: Policies, begin: Callable[[int], None]
    ) -> list[Experience | Exception]:
        """Take `steps` steps in every run; call `begin(k)` whenever run k begins an episode.

        For a run in which something raises, the result is that error, now and later.
        """
        environment, runs = self._environment, len(self._seeds)
        taken = self._empty(steps * runs)
        states = np.empty((steps * runs, environment.state_size))
        features = environment.features(self._states)
        for step in range(steps):
            rows = slice(step * runs, (step + 1) * runs)
            actions = policies.act(features)
            states[rows] = self._states
            with np.errstate(over="ignore"):
                taken.features[rows] = features
            taken.actions[rows] = actions
            steps_taken, failed = call_rows(self._advance, self._states, actions)
            self._failures = failed | self._failures
            if steps_taken is None:
                break
            features = self._go_on(steps_taken, rows, taken, begin)
        return [
            self._failures.get(k)
            or Experience(Memory(*(part[k::runs] for part in taken)), states[k::runs])
            for k in range(runs)
        ]

    def _advance(self, states: FloatArray, actions: FloatArray) -> Transition | Linearization:
        """Step the states, with derivatives if `linearized`."""
        if self._linearized:
            return self._environment.differentiate(states, actions)
        return self._environment.step(states, actions)

    def _go_on(
        self,
        steps: Transition | Linearization,
        rows: slice,
        taken: Memory,
        begin: Callable[[int], None],
    ) -> FloatArray:
        """Store a step of every run in `rows` of `taken`; return the features to act on next."""
        environment = self._environment
        transition = self._note(steps, rows, taken)
        self._elapsed += 1
        ended = transition.terminated
        out_of_time = self._elapsed >= environment.horizon
        final = ended | out_of_time if self._time_limit_is_terminal else ended
        features = environment.features(transition.next_state)
        with np.errstate(over="ignore"):  # beyond float32: `replay.check_finite` says so
            taken.rewards[rows] = transition.reward
            taken.next_features[rows] = features
        taken.continues[rows] = ~final
        self._states = transition.next_state
        over = ended | out_of_time
        if over.any():
            self._begin_episodes(np.flatnonzero(over).tolist(), begin)
            features = environment.features(self._states)
        return features

    def _note(self, steps: Transition | Linearization, rows: slice, taken: Memory) -> Transition:
        """Store the derivatives, if any, in `rows` of `taken`; return the transition."""
        if isinstance(steps, Transition):
            return steps
        rewards, jacobians = fold(self._environment, self._coordinates, steps)
        taken.reward_gradients[rows] = rewards
        taken.jacobians[rows] = jacobians
        return steps.transition

    def _empty(self, rows: int) -> Memory:
        return empty_memory(rows, self._environment, self._coordinates, linearized=self._linearized)

    def _begin_episodes(self, runs: Sequence[int], begin: Callable[[int], None]) -> None:
        for k in runs:
            self.episodes[k] += 1
            self._elapsed[k] = 0
            purpose = (self._seeds[k], "episode", int(self.episodes[k]))
            [self._states[k]], failed = start_states(self._environment, [purpose])
            for error in failed.values():
                self._failures.setdefault(k, error)
            begin(k)
