"""The compiled heart of TD3 and its hybrid: a cycle of updates of one run.

Each update: draw a batch; the critics' target, and its gradient if w1 or w2 is not 0,

    a'   = clip(pi'(s') + clip(sigma noise, -bound, bound), -1, 1)
    Qhat = r + gamma c min(Q1', Q2')(s', a')                                      c = 1 - terminated

then one Adam step of each critic down its losses (algorithms.matching.losses). Every second update
also steps the actor up Q1(s, pi(s)), and lets all targets follow.

The gradient of Qhat goes through a' where that lies within the bounds of the actions: da'/ds' is
dpi'/ds' there, and 0 where a' is clipped to them.
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
from algorithms.networks import actor, finite, network, optimizer
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.optimizer import Learned
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Coordinates, Scaling
from algorithms.networks.shape import Shape
from physics.kernels.compiled import compiled_fast

HALF, ONE = np.float32(0.5), np.float32(1)


class Rates(NamedTuple):
    """The numbers of the update rule."""

    gamma: np.float32
    tau: np.float32
    actor_rate: float
    critic_rate: float
    target_noise: np.float32
    """Sigma."""
    noise_bound: np.float32
    delay: int
    """Updates of the critics for each update of the actor."""


class Networks(NamedTuple):
    """The parameters that one run learns."""

    actor: Learned
    critics: tuple[Learned, Learned]


class Work(NamedTuple):
    """Arrays that an update overwrites."""

    batch: Batch
    actor: Pass
    actions: Array
    """[B, m]"""
    smoothed: Array
    """[B, m], the target's actions with their noise."""
    actor_gradient: Array
    """[P]"""
    following: tuple[Pass, Pass]
    """The passes of the target critics."""
    fit: CriticWork


@compiled_fast
def new_work(memory: Memory, networks: Networks, rows: int, shapes: Any) -> Work:
    """Arrays for updates of `rows` transitions each."""
    actor_shape, critic_shape = shapes
    theta, columns = networks.actor.theta, memory.reward_gradients.shape[1]
    return Work(
        replay.new_batch(memory, rows),
        network.new_pass(theta, rows, actor_shape),
        np.empty((rows, actor_shape.outputs), theta.dtype),
        np.empty((rows, actor_shape.outputs), theta.dtype),
        np.empty_like(theta),
        (network.new_pass(theta, rows, critic_shape), network.new_pass(theta, rows, critic_shape)),
        critic.new_critic_work(networks.critics[0].theta, rows, critic_shape, columns),
    )


@compiled_fast
def update(
    networks: Networks,
    done: int,
    memory: Memory,
    indices: NDArray[np.int64],
    noise: Array,
    coordinates: Coordinates,
    scaling: Scaling,
    rates: Rates,
    matching: Matching,
    shapes: tuple[Shape, Shape],
    report: Report,
) -> tuple[int, int]:
    """Update on the batches `indices [U, B]`, after `done` earlier updates.

    `noise [U, B, m]` is standard normal. The actor gradient in a report is that of the last update
    that stepped the actor, 0 before the first.

    Returns:
        As `algorithms.actor_critic.ddpg_update.update`.
    """
    actor_shape, critic_shape = shapes
    work = new_work(memory, networks, indices.shape[1], shapes)
    pi = Parameters(networks.actor.theta, actor_shape)
    pi_gradient = Parameters(work.actor_gradient, actor_shape)
    real = work.actions.dtype.type
    actor_norm, actor_size = real(0), real(0)
    for u in range(indices.shape[0]):
        matched = losses.due(matching, done + u)
        replay.draw(memory, indices[u], scaling, work.batch)
        if losses.is_matched(matched):
            replay.draw_derivatives(
                memory, indices[u], coordinates, scaling, work.batch, matched.shift
            )
        aim(networks, noise[u], rates, scaling, matched, work, shapes)
        step = optimizer.corrected(rates.critic_rate, done + u + 1)
        critic_norm, critic_size = real(0), real(0)
        for learned in networks.critics:
            norm, size = fit_critic(
                learned, coordinates, scaling, matched, step, work, critic_shape, report, u
            )
            critic_norm += norm
            critic_size += size
        if (done + u + 1) % rates.delay == 0:
            q = Parameters(networks.critics[0].theta, critic_shape)
            actor_gradient(
                pi, q, work.batch.x, work.actor, work.fit.critic, work.actions, pi_gradient
            )
            step = optimizer.corrected(rates.actor_rate, (done + u + 1) // rates.delay)
            actor_norm, actor_size = optimizer.adam(networks.actor, work.actor_gradient, step)
            optimizer.follow(networks.actor, rates.tau)
            for learned in networks.critics:
                optimizer.follow(learned, rates.tau)
        report.actor_gradient_norm[u] = np.sqrt(actor_norm)
        lost = finite.first_not_finite((
            report.critic_loss[u], report.gradient_loss[u],
            critic_norm, actor_norm, critic_size, actor_size,
        ))  # fmt: skip
        if lost >= 0:
            return u, lost
    return int(indices.shape[0]), -1


@compiled_fast
def aim(
    networks: Networks,
    noise: Array,
    rates: Rates,
    scaling: Scaling,
    matching: Matching,
    work: Work,
    shapes: tuple[Shape, Shape],
) -> None:
    """The critics' target and, where gradients are matched, its gradient."""
    actor_shape, critic_shape = shapes
    batch, fit = work.batch, work.fit
    pi = Parameters(networks.actor.target, actor_shape)
    first, second = networks.critics
    critics = Parameters(first.target, critic_shape), Parameters(second.target, critic_shape)
    network.receive(work.actor, batch.next_x)
    actor.choose(pi, work.actor, work.actions)
    smooth(work.actions, noise, rates, work.smoothed)
    bellman.least_value(critics, batch.next_x, work.smoothed, work.following, fit.value)
    bellman.back_up(batch, rates.gamma, scaling, fit.value)
    if losses.is_matched(matching):
        bellman.least_gradient(critics, work.following)
        by_input = work.following[0].x_bar
        hold_at_bounds(work.smoothed, batch.x.shape[1], by_input)
        bellman.through_policy(
            pi, batch, rates.gamma, work.actor, by_input, work.actions, fit.target
        )
        losses.blind(matching, fit.target)


@compiled_fast
def smooth(actions: Array, noise: Array, rates: Rates, result: Array) -> None:
    """Actions with clipped noise, within their bounds."""
    for row in range(actions.shape[0]):
        for i in range(actions.shape[1]):
            e = rates.target_noise * noise[row, i]
            e = min(max(e, -rates.noise_bound), rates.noise_bound)
            result[row, i] = min(max(actions[row, i] + e, -ONE), ONE)


@compiled_fast
def hold_at_bounds(smoothed: Array, features: int, by_input: Array) -> None:
    """Set the gradient in an action that is clipped to its bounds to 0."""
    for row in range(smoothed.shape[0]):
        for i in range(smoothed.shape[1]):
            if abs(smoothed[row, i]) >= ONE:
                by_input[row, features + i] = 0


@compiled_fast
def fit_critic(
    learned: Learned,
    coordinates: Coordinates,
    scaling: Scaling,
    matching: Matching,
    step: Any,
    work: Work,
    shape: Shape,
    report: Report,
    u: int,
) -> tuple[Any, Any]:
    """Step one critic, add half of its numbers to the report; return its squared norms."""
    fit = work.fit
    q, result = Parameters(learned.theta, shape), Parameters(fit.theta_gradient, shape)
    value_loss, gradient_loss = critic.fit(q, work.batch, coordinates, matching, fit, result)
    report.critic_loss[u] += HALF * value_loss
    report.gradient_loss[u] += HALF * gradient_loss
    describe(fit.critic.out, fit.value, HALF, scaling, report, u)
    norm, size = optimizer.adam(learned, fit.theta_gradient, step)
    report.critic_gradient_norm[u] += HALF * np.sqrt(norm)
    return norm, size


@compiled_fast
def gradient_pair(
    networks: Networks,
    memory: Memory,
    coordinates: Coordinates,
    scaling: Scaling,
    rates: Rates,
    matching: Matching,
    shapes: tuple[Shape, Shape],
) -> tuple[Array, Array]:
    """The first critic's gradient [B, C + m] and its target, at every transition of a memory.

    The target's actions are without noise.
    """
    indices = np.arange(memory.rewards.size)
    work = new_work(memory, networks, indices.size, shapes)
    replay.draw(memory, indices, scaling, work.batch)
    replay.draw_derivatives(memory, indices, coordinates, scaling, work.batch, 0)
    silence = np.zeros_like(work.actions)
    matched = Matching(ONE, ONE, matching.loss, 0, True, 1)
    aim(networks, silence, rates, scaling, matched, work, shapes)
    first = Parameters(networks.critics[0].theta, shapes[1])
    critic.own_gradient(first, work.batch, coordinates, work.fit)
    return work.fit.gradient, work.fit.target
