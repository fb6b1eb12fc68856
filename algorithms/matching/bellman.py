"""The critic's target for a deterministic policy, and the target's gradient (equation 2).

    Qhat  = r + gamma c Q'(s', pi'(s'))                                           c = 1 - terminated
    dQhat = dr/dz + dr/ds' J + gamma c (dQ'/ds' + dQ'/da' dpi'/ds') J             z = (s, a)

Both in normalised units (algorithms.networks.scaling), both constants to the critic's loss.

Source: "D3PG: Deep Differentiable Deterministic Policy Gradients" (2019), equation 2, with the
terminal factor c that it leaves out.
"""

from typing import Any

from algorithms.experience.replay import Batch
from algorithms.matching.critic import join
from algorithms.networks import actor, network
from algorithms.networks.layer import Array
from algorithms.networks.network import Parameters, Pass
from algorithms.networks.scaling import Scaling
from physics.kernels.compiled import compiled_fast


@compiled_fast
def target_value(
    actor_target: Parameters,
    critic_target: Parameters,
    batch: Batch,
    gamma: Any,
    scaling: Scaling,
    actor_work: Pass,
    critic_work: Pass,
    next_actions: Array,
    value: Array,
) -> None:
    """The normalised target `value [B]`; leaves both target networks' passes in the work arrays."""
    network.receive(actor_work, batch.next_x)
    actor.choose(actor_target, actor_work, next_actions)
    join(batch.next_x, next_actions, critic_work.x)
    network.forward(critic_target, critic_work)
    back_up(batch, gamma, scaling, critic_work.out, value)


@compiled_fast
def target_gradient(
    actor_target: Parameters,
    critic_target: Parameters,
    batch: Batch,
    gamma: Any,
    actor_work: Pass,
    critic_work: Pass,
    next_actions: Array,
    result: Array,
) -> None:
    """The normalised target gradient [B, C + m], after `target_value` with the same arrays."""
    features = batch.x.shape[1]
    critic_work.out_bar[:] = 1
    network.backward_to_input(critic_target, critic_work)
    actor.pull_back(next_actions, critic_work.x_bar, features, actor_work)
    network.backward_to_input(actor_target, actor_work)
    for row in range(result.shape[0]):
        for i in range(features):
            actor_work.x_bar[row, i] += critic_work.x_bar[row, i]
    back_up_gradient(batch, gamma, actor_work.x_bar, result)


@compiled_fast
def back_up(batch: Batch, gamma: Any, scaling: Scaling, following: Array, value: Array) -> None:
    """`r + gamma c following`, for what follows [B, 1], to `value [B]`; both normalised."""
    for row in range(value.size):
        q = scaling.value_mean + scaling.value_std * following[row, 0]
        raw = batch.rewards[row] + gamma * batch.continues[row] * q
        value[row] = (raw - scaling.value_mean) / scaling.value_std


@compiled_fast
def back_up_gradient(batch: Batch, gamma: Any, by_next: Array, result: Array) -> None:
    """`dr + gamma c by_next J` [B, C + m], for the derivative by the next features [B, F]."""
    for row in range(result.shape[0]):
        factor = gamma * batch.continues[row]
        for j in range(result.shape[1]):
            result[row, j] = batch.reward_gradients[row, j]
        for i in range(by_next.shape[1]):
            for j in range(result.shape[1]):
                result[row, j] += factor * by_next[row, i] * batch.jacobians[row, i, j]
