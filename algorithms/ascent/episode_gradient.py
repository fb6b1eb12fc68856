"""The exact gradient of whole episodes' returns with respect to the actor that acted in them.

    R = sum over t < e of  r(s_t, a_t, s_{t+1}),    a_t = pi(s_t),   s_{t+1} = f(s_t, a_t)

Backwards in time, with lambda the gradient of what is still to be earned (0 from the end e on, be
it the task's or the time limit) and J the Jacobians of the step:

    q        = lambda_{t+1} + r_s'
    abar_t   = r_a + J_a' q
    lambda_t = r_s + J_s' q + (dpi/ds)' abar_t
    dR/dtheta = sum over t of  abar_t' dpi(s_t)/dtheta

The network is worked on all steps at once: first its own Jacobians, then, once the recursion has
found every abar, one backward pass.

Glossary: `T` steps, `E` episodes of one actor, `K` actors; `n`, `m`, `F` sizes of states, actions
and features; `N = T E` rows, time first.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.failing_rows import Failures, call_rows
from algorithms.networks import actor, network
from algorithms.networks.layer import Array
from algorithms.networks.network import Parameters, Shape
from algorithms.networks.policy import Policies, Policy
from algorithms.networks.scaling import CLIP, normalise
from algorithms.networks.squash import squash_slope
from physics.environment import Environment
from physics.kernels.compiled import compiled, compiled_fast

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class LinearizedEpisodes(NamedTuple):
    """Episodes with the derivatives of all their steps; those from an episode's end on are void."""

    features: Floats
    """[T, K, E, F]"""
    slopes: Floats
    """[T, K, E, F], of each feature in its source coordinate."""
    rewards: Floats
    """[T, K, E], 0 from the end on."""
    state_jacobian: Floats
    """[T, K, E, n, n]"""
    action_jacobian: Floats
    """[T, K, E, n, m]"""
    reward_state: Floats
    """[T, K, E, n], partial derivative of the reward in s."""
    reward_action: Floats
    """[T, K, E, m]"""
    reward_next: Floats
    """[T, K, E, n]"""
    ends: Integers
    """[K, E], steps each episode had."""

    def of(self, k: int) -> "LinearizedEpisodes":
        """The episodes of actor k, `[T, E, ...]`, T the length of its own longest.

        Not of the cohort's: a product's bits may depend on how many rows it has, void ones too.
        """
        steps = self.ends[k].max()
        parts = [np.ascontiguousarray(part[:steps, k]) for part in self[:-1]]
        return LinearizedEpisodes._make([*parts, self.ends[k]])


def live(
    environment: Environment, policies: Sequence[Policy], shape: Shape, starts: Floats
) -> tuple[LinearizedEpisodes | None, Failures]:
    """Let each of K actors live E episodes from its start states [K, E, n].

    Returns:
        The episodes, void for those that failed, None if all did; and, by `k E + e`, how they did.
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
    parts = [part.reshape(part.shape[0], actors, each, *part.shape[2:]) for part in stacked]
    return LinearizedEpisodes._make([*parts, ends.reshape(actors, each)]), failures


@compiled_fast
def return_gradient(
    theta: Array,
    shape: Shape,
    mean: Array,
    inverse: Array,
    sources: Integers,
    episodes: LinearizedEpisodes,
    gradient: Array,
) -> None:
    """Fill `gradient [P]` with that of one actor's mean return over its episodes [T, E, ...].

    Args:
        theta: the actor's parameters [P].
        shape: its sizes.
        mean, inverse: normalisation of its features [F].
        sources: the coordinate each feature depends on [F].
        episodes: its episodes.
        gradient: the result.
    """
    steps, each, _ = episodes.features.shape
    n, m = episodes.action_jacobian.shape[2:]
    pi = Parameters(theta, shape)
    work = network.new_pass(theta, steps * each, shape)
    actions = np.empty((steps * each, m), theta.dtype)
    see(episodes, mean, inverse, work.x)
    actor.choose(pi, work, actions)
    policy_jacobian = np.zeros((steps, each, m, n))
    differentiate_policy(pi, work, actions, inverse, sources, episodes, policy_jacobian)
    action_bar = np.zeros((steps, each, m))
    go_back(episodes, policy_jacobian, action_bar)
    for row in range(steps * each):
        for k in range(m):
            bar = action_bar[row // each, row % each, k] / each
            work.out_bar[row, k] = theta.dtype.type(bar) * squash_slope(actions[row, k])
    network.backward(pi, work)
    network.gradient(pi, work, Parameters(gradient, shape))


@compiled_fast
def see(episodes: LinearizedEpisodes, mean: Array, inverse: Array, x: Array) -> None:
    """Fill the normalised features [N, F]."""
    each = episodes.features.shape[1]
    for row in range(x.shape[0]):
        for i in range(x.shape[1]):
            feature = episodes.features[row // each, row % each, i]
            x[row, i] = normalise(np.float32(feature), mean[i], inverse[i])


@compiled_fast
def differentiate_policy(
    pi: Any,
    work: Any,
    actions: Array,
    inverse: Array,
    sources: Integers,
    episodes: LinearizedEpisodes,
    policy_jacobian: Floats,
) -> None:
    """Add dpi/ds to `policy_jacobian [T, E, m, n]`, 0 on entry; a clipped feature has no slope."""
    each, m = policy_jacobian.shape[1], policy_jacobian.shape[2]
    for k in range(m):
        work.out_bar[:] = 0
        for row in range(actions.shape[0]):
            work.out_bar[row, k] = squash_slope(actions[row, k])
        network.backward_to_input(pi, work)
        for row in range(actions.shape[0]):
            t, e = row // each, row % each
            for i in range(sources.size):
                if abs(work.x[row, i]) < CLIP:
                    by_coordinate = inverse[i] * episodes.slopes[t, e, i]
                    policy_jacobian[t, e, k, sources[i]] += work.x_bar[row, i] * by_coordinate


@compiled
def go_back(episodes: LinearizedEpisodes, policy_jacobian: Floats, action_bar: Floats) -> None:
    """Fill `action_bar [T, E, m]`, which is 0 on entry, from the last step to the first."""
    _, each, m, n = policy_jacobian.shape
    later, now, q = np.empty(n), np.empty(n), np.empty(n)
    for e in range(each):
        later[:] = 0.0
        for t in range(episodes.ends[e] - 1, -1, -1):
            J_s, J_a = episodes.state_jacobian[t, e], episodes.action_jacobian[t, e]
            for j in range(n):
                q[j] = later[j] + episodes.reward_next[t, e, j]
                now[j] = episodes.reward_state[t, e, j]
            for k in range(m):
                bar = episodes.reward_action[t, e, k]
                for j in range(n):
                    bar += J_a[j, k] * q[j]
                action_bar[t, e, k] = bar
                for i in range(n):
                    now[i] += policy_jacobian[t, e, k, i] * bar
            for j in range(n):
                for i in range(n):
                    now[i] += J_s[j, i] * q[j]
            later[:] = now
