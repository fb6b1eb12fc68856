"""The compiled heart of DDPG and its hybrid: a cycle of updates of one run.

Each update: draw a batch; the critic's target, and its gradient if w1 or w2 is not 0; one Adam step
of the critic down its losses (algorithms.matching.losses, plus weight decay of its hidden
products); one of the actor up the critic,

    d(actor)/dtheta = 1/B sum dQ/da|a=pi(s) dpi(s)/dtheta

with both gradients at the parameters before the update; then both targets follow.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.actor_critic.deterministic import Report, actor_gradient, describe
from algorithms.experience import replay
from algorithms.experience.replay import Batch, Memory
from algorithms.matching import bellman, critic, losses
from algorithms.matching.critic import CriticWork
from algorithms.matching.losses import Matching
from algorithms.networks import finite, network, optimizer
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.optimizer import Learned
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Coordinates, Scaling
from algorithms.networks.shape import Shape, decayed_size
from physics.kernels.compiled import compiled_fast


class Rates(NamedTuple):
    """The numbers of the update rule."""

    gamma: np.float32
    tau: np.float32
    actor_rate: float
    critic_rate: float
    critic_decay: np.float32


class Work(NamedTuple):
    """Arrays that an update overwrites."""

    batch: Batch
    actor: Pass
    actions: Array
    """[B, m]"""
    actor_gradient: Array
    """[P]"""
    fit: CriticWork


@compiled_fast
def new_work(
    memory: Memory, learned_actor: Learned, learned_critic: Learned, rows: int, shapes: Any
) -> Work:
    """Arrays for updates of `rows` transitions each."""
    actor_shape, critic_shape = shapes
    columns = memory.reward_gradients.shape[1]
    return Work(
        replay.new_batch(memory, rows),
        network.new_pass(learned_actor.theta, rows, actor_shape),
        np.empty((rows, actor_shape.outputs), learned_actor.theta.dtype),
        np.empty_like(learned_actor.theta),
        critic.new_critic_work(learned_critic.theta, rows, critic_shape, columns),
    )


@compiled_fast
def update(
    learned_actor: Learned,
    learned_critic: Learned,
    done: int,
    memory: Memory,
    indices: NDArray[np.int64],
    coordinates: Coordinates,
    scaling: Scaling,
    rates: Rates,
    matching: Matching,
    shapes: tuple[Shape, Shape],
    report: Report,
) -> tuple[int, int]:
    """Update on the batches `indices [U, B]`, after `done` earlier updates.

    Returns:
        How many of the U updates were done, and -1; or, if a number in an update is not finite, how
        many were done before it, and the number's index in `QUANTITIES`.
    """
    actor_shape, critic_shape = shapes
    work = new_work(memory, learned_actor, learned_critic, indices.shape[1], shapes)
    pi = Parameters(learned_actor.theta, actor_shape)
    q = Parameters(learned_critic.theta, critic_shape)
    pi_target = Parameters(learned_actor.target, actor_shape)
    q_target = Parameters(learned_critic.target, critic_shape)
    pi_gradient = Parameters(work.actor_gradient, actor_shape)
    q_gradient = Parameters(work.fit.theta_gradient, critic_shape)
    fit, decayed = work.fit, decayed_size(critic_shape)
    for u in range(indices.shape[0]):
        matched = losses.due(matching, done + u)
        replay.draw(memory, indices[u], scaling, work.batch)
        bellman.target_value(
            pi_target, (q_target,), work.batch, rates.gamma, scaling,
            work.actor, (fit.critic,), work.actions, fit.value,
        )  # fmt: skip
        if losses.is_matched(matched):
            replay.draw_derivatives(
                memory, indices[u], coordinates, scaling, work.batch, matched.shift
            )
            bellman.target_gradient(
                pi_target, (q_target,), work.batch, rates.gamma,
                work.actor, (fit.critic,), work.actions, fit.target,
            )  # fmt: skip
            losses.blind(matched, fit.target)
        report.critic_loss[u], report.gradient_loss[u] = critic.fit(
            q, work.batch, coordinates, matched, fit, q_gradient
        )
        describe(fit.critic.out, fit.value, np.float32(1), scaling, report, u)
        actor_gradient(pi, q, work.batch.x, work.actor, fit.critic, work.actions, pi_gradient)
        optimizer.decay(learned_critic.theta, decayed, rates.critic_decay, fit.theta_gradient)
        step = optimizer.corrected(rates.critic_rate, done + u + 1)
        critic_norm, critic_size = optimizer.adam(learned_critic, fit.theta_gradient, step)
        step = optimizer.corrected(rates.actor_rate, done + u + 1)
        actor_norm, actor_size = optimizer.adam(learned_actor, work.actor_gradient, step)
        optimizer.follow(learned_critic, rates.tau)
        optimizer.follow(learned_actor, rates.tau)
        report.critic_gradient_norm[u] = np.sqrt(critic_norm)
        report.actor_gradient_norm[u] = np.sqrt(actor_norm)
        lost = finite.first_not_finite((
            report.critic_loss[u], report.gradient_loss[u],
            critic_norm, actor_norm, critic_size, actor_size,
        ))  # fmt: skip
        if lost >= 0:
            return u, lost
    return int(indices.shape[0]), -1


@compiled_fast
def gradient_pair(
    learned_actor: Learned,
    learned_critic: Learned,
    memory: Memory,
    coordinates: Coordinates,
    scaling: Scaling,
    gamma: Any,
    shapes: tuple[Shape, Shape],
) -> tuple[Array, Array]:
    """The critic's gradient [B, C + m] and its target, at every transition of a memory."""
    actor_shape, critic_shape = shapes
    indices = np.arange(memory.rewards.size)
    work = new_work(memory, learned_actor, learned_critic, indices.size, shapes)
    fit = work.fit
    replay.draw(memory, indices, scaling, work.batch)
    replay.draw_derivatives(memory, indices, coordinates, scaling, work.batch, 0)
    pi_target = Parameters(learned_actor.target, actor_shape)
    q_target = Parameters(learned_critic.target, critic_shape)
    bellman.target_value(
        pi_target, (q_target,), work.batch, gamma, scaling,
        work.actor, (fit.critic,), work.actions, fit.value,
    )  # fmt: skip
    bellman.target_gradient(
        pi_target,
        (q_target,),
        work.batch,
        gamma,
        work.actor,
        (fit.critic,),
        work.actions,
        fit.target,
    )
    critic.own_gradient(
        Parameters(learned_critic.theta, critic_shape), work.batch, coordinates, fit
    )
    return fit.gradient, fit.target
