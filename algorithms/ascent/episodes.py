"""Whole episodes of a deterministic actor, and the exact gradient of their returns.

    R = sum over t < e of  r(s_t, a_t, s_{t+1}),    a_t = pi(s_t),   s_{t+1} = f(s_t, a_t)

An episode is a column of steps without noise, undivided and undiscounted; after its end e, whether
by the task or by the time limit, rewards are 0 (algorithms.ascent.pathwise).

Glossary: `T` steps, `E` episodes of one actor, `K` actors; `n`, `m`, `F` sizes of states, actions
and features.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from algorithms.ascent.pathwise import (
    Floats,
    Integers,
    Linearized,
    Stretches,
    ascent_direction,
    undivided,
)
from algorithms.failing_rows import Failures, call_rows
from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.parameters import Parameters
from algorithms.networks.policy import Policies, Policy
from algorithms.networks.shape import Shape
from physics.environment import Environment
from physics.kernels.compiled import compiled_fast


class LinearizedEpisodes(NamedTuple):
    """Episodes of K actors, with the derivatives of all their steps."""

    steps: tuple[Floats, ...]
    """[T, K, E, ...], the fields of `Linearized` for each actor."""
    ends: Integers
    """[K, E], the number of steps of each episode."""

    def of(self, k: int) -> Linearized:
        """The episodes of actor k, `[T, E, ...]`, T the length of its own longest episode.

        T is not that of the cohort, because a product's bits may depend on its number of rows,
        void rows included.
        """
        longest = self.ends[k].max()
        parts = [np.ascontiguousarray(part[:longest, k]) for part in self.steps]
        return Linearized._make([*parts, self.ends[k]])


def live(
    environment: Environment, policies: Sequence[Policy], shape: Shape, starts: Floats
) -> tuple[LinearizedEpisodes | None, Failures]:
    """Run E episodes of each of K actors from its start states [K, E, n].

    Returns:
        The episodes, void where they failed, None if all did; and the failures, by `k E + e`.
    """
    actors, each, n = starts.shape
    everyone = Policies([policy for policy in policies for _ in range(each)], shape)
    states = starts.reshape(-1, n)
    ends = np.full(len(states), environment.horizon)
    rows: list[tuple[Floats, ...]] = []
    failures: Failures = {}
    for t in range(environment.horizon):
        features = environment.features(states)
        steps, failed = call_rows(environment.differentiate, states, everyone.act(features))
        failures = failed | failures
        if steps is None:
            return None, failures
        step, *derivatives = steps
        is_running = ends > t
        slopes = environment.feature_slopes(features)
        rows.append((features, slopes, np.where(is_running, step.reward, 0.0), *derivatives))
        ends[is_running & step.terminated] = t + 1
        if not (ends > t + 1).any():
            break
        states = np.where((ends > t + 1)[:, None], step.next_state, states)
    stacked = (np.stack(part) for part in zip(*rows, strict=True))
    parts = (part.reshape(part.shape[0], actors, each, *part.shape[2:]) for part in stacked)
    return LinearizedEpisodes(tuple(parts), ends.reshape(actors, each)), failures


def return_gradient(
    policy: Policy, shape: Shape, sources: Integers, episodes: Linearized, gradient: Array
) -> None:
    """Fill `gradient [P]` with that of one actor's mean return over its episodes [T, E, ...].

    Args:
        policy: the actor.
        shape: its sizes.
        sources: the coordinate each feature depends on [F].
        episodes: its episodes.
        gradient: the result.
    """
    theta, mean, inverse, _ = policy
    fill_return_gradient(
        theta, shape, mean, inverse, sources, episodes, undivided(episodes), gradient
    )


@compiled_fast
def fill_return_gradient(
    theta: Array,
    shape: Shape,
    mean: Array,
    inverse: Array,
    sources: Integers,
    episodes: Linearized,
    stretches: Stretches,
    gradient: Array,
) -> None:
    """`return_gradient`, compiled."""
    rows = episodes.rewards.size
    work = network.new_pass(theta, rows, shape)
    noise = np.zeros((rows, shape.outputs), theta.dtype)
    ascent_direction(
        Parameters(theta, shape), work, mean, inverse, sources, episodes, stretches, noise,
        Parameters(gradient, shape),
    )  # fmt: skip
