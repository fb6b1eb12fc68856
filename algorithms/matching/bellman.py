"""The critic's target for a deterministic policy, and the target's gradient (equation 2).

    Qhat  = r + gamma c Q'(s', pi'(s'))                                           c = 1 - terminated
    dQhat = dr/dz + dr/ds' J + gamma c (dQ'/ds' + dQ'/da' dpi'/ds') J             z = (s, a)

Both are in normalised units (algorithms.networks.scaling), and both are constants in the critic's
loss. Of several Q', the least at (s', a') is used, with its gradient.

Source: "D3PG: Deep Differentiable Deterministic Policy Gradients" (2019), equation 2, with the
terminal factor c that it leaves out.
"""

from typing import Any

import numpy as np

from algorithms.experience.replay import Batch
from algorithms.matching.critic import join
from algorithms.networks import actor, network
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Scaling
from physics.kernels.compiled import compiled_fast


@compiled_fast
def target_value(
    actor_target: Parameters,
    critic_targets: tuple[Parameters, ...],
    batch: Batch,
    gamma: Any,
    scaling: Scaling,
    actor_work: Pass,
    critic_works: tuple[Pass, ...],
    next_actions: Array,
    value: Array,
) -> None:
    """Fill the normalised target `value [B]` and the passes of all target networks."""
    network.receive(actor_work, batch.next_x)
    actor.choose(actor_target, actor_work, next_actions)
    least_value(critic_targets, batch.next_x, next_actions, critic_works, value)
    back_up(batch, gamma, scaling, value)


@compiled_fast
def target_gradient(
    actor_target: Parameters,
    critic_targets: tuple[Parameters, ...],
    batch: Batch,
    gamma: Any,
    actor_work: Pass,
    critic_works: tuple[Pass, ...],
    next_actions: Array,
    result: Array,
) -> None:
    """Fill the normalised target gradient [B, C + m], after `target_value` with the same arrays."""
    least_gradient(critic_targets, critic_works)
    by_input = critic_works[0].x_bar
    through_policy(actor_target, batch, gamma, actor_work, by_input, next_actions, result)


@compiled_fast
def through_policy(
    actor_target: Parameters,
    batch: Batch,
    gamma: Any,
    actor_work: Pass,
    by_input: Array,
    next_actions: Array,
    result: Array,
) -> None:
    """Fill the target gradient from that of Q' in its inputs, `by_input [B, F + m]`."""
    features = batch.x.shape[1]
    actor.pull_back(next_actions, by_input, features, actor_work)
    network.backward_to_input(actor_target, actor_work)
    for row in range(result.shape[0]):
        for i in range(features):
            actor_work.x_bar[row, i] += by_input[row, i]
    back_up_gradient(batch, gamma, actor_work.x_bar, result)


@compiled_fast
def least_value(
    critics: tuple[Parameters, ...], x: Array, actions: Array, works: tuple[Pass, ...], value: Array
) -> None:
    """Fill the least Q [B] of the critics at features `x [B, F]` and actions [B, m]."""
    value[:] = np.inf
    for k in range(len(critics)):
        join(x, actions, works[k].x)
        network.forward(critics[k], works[k])
        for row in range(value.size):
            value[row] = min(value[row], works[k].out[row, 0])


@compiled_fast
def least_gradient(critics: tuple[Parameters, ...], works: tuple[Pass, ...]) -> None:
    """Write the input gradient of the least Q into the first `x_bar`, after `least_value`."""
    for k in range(len(critics)):
        for row in range(works[k].x.shape[0]):
            works[k].out_bar[row, 0] = is_least(works, row, k)
        network.backward_to_input(critics[k], works[k])
    total = works[0].x_bar
    for k in range(1, len(critics)):
        for row in range(total.shape[0]):
            for i in range(total.shape[1]):
                total[row, i] += works[k].x_bar[row, i]


@compiled_fast
def is_least(works: tuple[Pass, ...], row: int, k: int) -> Any:
    """Whether the row's least Q is that of critic k; of equal ones, the first counts."""
    own = works[k].out[row, 0]
    for other in range(len(works)):
        q = works[other].out[row, 0]
        if q < own or (q == own and other < k):
            return False
    return True


@compiled_fast
def back_up(batch: Batch, gamma: Any, scaling: Scaling, value: Array) -> None:
    """Replace `value [B]` of the next states by `r + gamma c value`; both normalised."""
    for row in range(value.size):
        q = scaling.value_mean + scaling.value_std * value[row]
        raw = batch.rewards[row] + gamma * batch.continues[row] * q
        value[row] = (raw - scaling.value_mean) / scaling.value_std


@compiled_fast
def back_up_gradient(batch: Batch, gamma: Any, by_next: Array, result: Array) -> None:
    """Fill `dr + gamma c by_next J` [B, C + m], for the derivative by the next features [B, F]."""
    for row in range(result.shape[0]):
        factor = gamma * batch.continues[row]
        for j in range(result.shape[1]):
            result[row, j] = batch.reward_gradients[row, j]
        for i in range(by_next.shape[1]):
            for j in range(result.shape[1]):
                result[row, j] += factor * by_next[row, i] * batch.jacobians[row, i, j]
