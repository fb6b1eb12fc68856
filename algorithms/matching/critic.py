"""The critic's part of an update: fit a Q to its target, and its gradient to the target's.

    L = value loss, or value loss + gradient loss                       (algorithms.matching.losses)

The gradient loss costs a tangent pass and a second-order backward pass in place of the backward
pass (algorithms.networks.network).
"""

from typing import Any, NamedTuple

import numpy as np

from algorithms.experience.replay import Batch
from algorithms.matching import losses
from algorithms.matching.losses import Matching
from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.network import Direction, Pass
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Coordinates
from algorithms.networks.shape import Shape
from physics.kernels.compiled import compiled_fast


class CriticWork(NamedTuple):
    """Arrays that fitting a critic overwrites."""

    critic: Pass
    moved: Direction
    value: Array
    """[B], the target of Q"""
    target: Array
    """[B, C + m], the target of Q's gradient"""
    gradient: Array
    """[B, C + m], Q's gradient"""
    direction: Array
    """[B, C + m]"""
    theta_gradient: Array
    """[P], the loss's gradient"""


@compiled_fast
def new_critic_work(theta: Array, rows: int, shape: Shape, columns: int) -> CriticWork:
    """Arrays for batches of `rows` transitions and gradients of `columns` = C + m entries."""
    kind = theta.dtype
    return CriticWork(
        network.new_pass(theta, rows, shape),
        network.new_direction(theta, rows, shape),
        np.empty(rows, kind),
        np.empty((rows, columns), kind),
        np.empty((rows, columns), kind),
        np.empty((rows, columns), kind),
        np.empty_like(theta),
    )


@compiled_fast
def join(x: Array, actions: Array, result: Array) -> None:
    """Put features and actions side by side [B, F + m], as a critic takes them."""
    features = x.shape[1]
    for row in range(x.shape[0]):
        for i in range(features):
            result[row, i] = x[row, i]
        for i in range(actions.shape[1]):
            result[row, features + i] = actions[row, i]


@compiled_fast
def fit(
    q: Parameters,
    batch: Batch,
    coordinates: Coordinates,
    matching: Matching,
    work: CriticWork,
    result: Parameters,
) -> tuple[Any, Any]:
    """Return the value loss and the gradient loss or 0; their sum's gradient goes to `result`."""
    if losses.is_matched(matching):
        return matched_fit(q, batch, coordinates, matching, work, result)
    return value_fit(q, batch, work, result), work.value.dtype.type(0)


@compiled_fast
def value_fit(q: Parameters, batch: Batch, work: CriticWork, result: Parameters) -> Any:
    """Return the value loss; its gradient goes to `result`."""
    join(batch.x, batch.actions, work.critic.x)
    network.forward(q, work.critic)
    loss = losses.value_loss(work.critic.out, work.value, work.critic.out_bar)
    network.backward(q, work.critic)
    network.gradient(q, work.critic, result)
    return loss


@compiled_fast
def matched_fit(
    q: Parameters,
    batch: Batch,
    coordinates: Coordinates,
    matching: Matching,
    work: CriticWork,
    result: Parameters,
) -> tuple[Any, Any]:
    """Return the value loss and the gradient loss; their sum's gradient goes to `result`."""
    critic, moved = work.critic, work.moved
    own_gradient(q, batch, coordinates, work)
    value_loss = losses.value_loss(critic.out, work.value, moved.out_til)
    gradient_loss = losses.gradient_loss(
        work.gradient,
        work.target,
        batch.continues,
        coordinates.seen.size,
        matching,
        work.direction,
    )
    losses.input_direction(batch, coordinates, work.direction, moved.x)
    network.tangent(q, critic, moved)
    network.second_backward(q, critic, moved, result)
    return value_loss, gradient_loss


@compiled_fast
def own_gradient(q: Parameters, batch: Batch, coordinates: Coordinates, work: CriticWork) -> None:
    """Compute Q at the batch, and its gradient with respect to z."""
    join(batch.x, batch.actions, work.critic.x)
    network.forward(q, work.critic)
    work.critic.out_bar[:] = 1
    network.backward_to_input(q, work.critic)
    losses.critic_gradient(batch, coordinates, work.critic.x_bar, work.gradient)
