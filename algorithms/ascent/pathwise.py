"""The exact gradient of the rewards of steps with respect to the actor that took them.

Steps lie in columns, one per row of simulated time; a column has one episode after the other. For a
stretch of a column, from the start of an episode or of the column to the end of either:

    J = sum over its steps of  discount^i r(s_i, a_i, s_{i+1})  +  discount^h W(s_h)
    a = tanh(mu(s) + e),   s' = f(s, a)

with W the value of what follows the stretch's h steps, and e the added noise, held constant.
Backwards in time, with lambda the gradient in s' of what follows a step (that of W after a
stretch's last step) and J the Jacobians of the step:

    q        = discount lambda' + r_s'
    abar     = r_a + J_a' q
    lambda   = r_s + J_s' q + (dpi/ds)' abar
    dJ/dtheta = sum over steps of  discount^i abar' dpi(s)/dtheta

The network is evaluated for all steps at once: first its own Jacobians, then, once the recursion
has computed every abar, one backward pass.

Glossary: `T` steps, `E` columns of one actor; `n`, `m`, `F` sizes of states, actions and features;
`N = T E` rows, time first.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import CLIP
from algorithms.networks.squash import squash, squash_slope
from algorithms.on_policy.values import see
from physics.kernels.compiled import compiled, compiled_fast

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Linearized(NamedTuple):
    """Steps with all their derivatives; those after a column's end are void."""

    features: Floats
    """[T, E, F]"""
    slopes: Floats
    """[T, E, F], of each feature in its source coordinate."""
    rewards: Floats
    """[T, E], 0 from the end on."""
    state_jacobian: Floats
    """[T, E, n, n]"""
    action_jacobian: Floats
    """[T, E, n, m]"""
    reward_state: Floats
    """[T, E, n], partial derivative of the reward in s."""
    reward_action: Floats
    """[T, E, m]"""
    reward_next: Floats
    """[T, E, n]"""
    ends: Integers
    """[E], steps each column has."""


class Stretches(NamedTuple):
    """How columns are divided into stretches."""

    is_last: NDArray[np.bool_]
    """[T, E], whether a stretch ends with the step; a column's last step need not be marked."""
    beyond: Floats
    """[T, E, n], gradient of W in s' where it ends; [0, 0, n] where all W are 0."""
    weights: Floats
    """[T, E], `discount^i` of each step in its stretch, in the unit of J."""
    discount: float


def undivided(linearized: Linearized) -> Stretches:
    """Each column as one stretch, with undiscounted rewards and no value after it."""
    shape, n = linearized.rewards.shape, linearized.reward_state.shape[-1]
    return Stretches(np.zeros(shape, np.bool_), np.zeros((0, 0, n)), np.ones(shape), 1.0)


@compiled_fast
def ascent_direction(
    pi: Parameters,
    work: Pass,
    mean: Array,
    inverse: Array,
    sources: Integers,
    linearized: Linearized,
    stretches: Stretches,
    noise: Array,
    gradient: Parameters,
) -> None:
    """Fill the gradient of J, the mean over columns, and `work.out_bar [N, m]`, that of mu(s).

    Args:
        pi: the actor.
        work: arrays of a pass over N rows.
        mean, inverse: normalisation of its features [F].
        sources: the coordinate each feature depends on [F].
        linearized: the actor's steps.
        stretches: how the columns are divided.
        noise: e [N, m].
        gradient: the result.
    """
    steps, columns, _ = linearized.features.shape
    n, m = linearized.action_jacobian.shape[2:]
    actions = np.empty((steps * columns, m), work.x.dtype)
    see(linearized.features, mean, inverse, work.x)
    network.forward(pi, work)
    for row in range(steps * columns):
        for k in range(m):
            actions[row, k] = squash(work.out[row, k] + noise[row, k])
    policy_jacobian = np.zeros((steps, columns, m, n))
    differentiate_policy(pi, work, actions, inverse, sources, linearized, policy_jacobian)
    action_bar = np.zeros((steps, columns, m))
    go_back(linearized, stretches, policy_jacobian, action_bar)
    for row in range(steps * columns):
        t, e = row // columns, row % columns
        for k in range(m):
            bar = stretches.weights[t, e] * action_bar[t, e, k] / columns
            work.out_bar[row, k] = work.x.dtype.type(bar) * squash_slope(actions[row, k])
    network.backward(pi, work)
    network.gradient(pi, work, gradient)


@compiled_fast
def differentiate_policy(
    pi: Any,
    work: Any,
    actions: Array,
    inverse: Array,
    sources: Integers,
    linearized: Linearized,
    policy_jacobian: Floats,
) -> None:
    """Add dpi/ds to `policy_jacobian [T, E, m, n]`, 0 on entry; a clipped feature has no slope."""
    columns, m = policy_jacobian.shape[1], policy_jacobian.shape[2]
    for k in range(m):
        work.out_bar[:] = 0
        for row in range(actions.shape[0]):
            work.out_bar[row, k] = squash_slope(actions[row, k])
        network.backward_to_input(pi, work)
        for row in range(actions.shape[0]):
            t, e = row // columns, row % columns
            for i in range(sources.size):
                if abs(work.x[row, i]) < CLIP:
                    by_coordinate = inverse[i] * linearized.slopes[t, e, i]
                    policy_jacobian[t, e, k, sources[i]] += work.x_bar[row, i] * by_coordinate


@compiled
def go_back(
    linearized: Linearized, stretches: Stretches, policy_jacobian: Floats, action_bar: Floats
) -> None:
    """Fill `action_bar [T, E, m]`, which is 0 on entry, from the last step to the first."""
    _, columns, m, n = policy_jacobian.shape
    ends_are_worth = stretches.beyond.size > 0
    later, now, q = np.empty(n), np.empty(n), np.empty(n)
    for e in range(columns):
        later[:] = 0.0
        for t in range(linearized.ends[e] - 1, -1, -1):
            if ends_are_worth and stretches.is_last[t, e]:
                later[:] = stretches.beyond[t, e]
            J_s, J_a = linearized.state_jacobian[t, e], linearized.action_jacobian[t, e]
            for j in range(n):
                q[j] = stretches.discount * later[j] + linearized.reward_next[t, e, j]
                now[j] = linearized.reward_state[t, e, j]
            for k in range(m):
                bar = linearized.reward_action[t, e, k]
                for j in range(n):
                    bar += J_a[j, k] * q[j]
                action_bar[t, e, k] = bar
                for i in range(n):
                    now[i] += policy_jacobian[t, e, k, i] * bar
            for j in range(n):
                for i in range(n):
                    now[i] += J_s[j, i] * q[j]
            later[:] = now
