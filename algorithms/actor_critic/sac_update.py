"""The compiled heart of soft actor-critic and its hybrid: a cycle of updates of one run.

Each update: draw a batch; the critics' target, and its gradient if w1 or w2 is not 0; then one Adam
step each of

    pi       down   1/B sum log pi(a~ | s) - Q1(s, a~)          a~ from fresh noise, reparameterised
    V        down   1/B sum (V(s) - Vhat)^2                     with the same a~
    Q1, Q2   down   the critic's losses (algorithms.matching.losses)

where V's target and pi's loss have log pi times a temperature alpha. Alpha is 1, or it is learned,
with one more step of Adam, so that the entropy approaches H; pi's loss is then in the unit of Q:

    log alpha   down   -log alpha (mean log pi + H)

All gradients are at the parameters before the update; then V' follows V.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.experience import replay
from algorithms.experience.replay import Batch, Memory
from algorithms.matching import critic, losses, soft_bellman
from algorithms.matching.critic import CriticWork
from algorithms.matching.losses import Matching
from algorithms.networks import finite, gaussian, network, optimizer
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.optimizer import Learned
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Coordinates, Scaling
from algorithms.networks.shape import Shape
from algorithms.state import State, part, within
from physics.kernels.compiled import compiled_fast

QUANTITIES = (
    "critic loss",
    "gradient loss",
    "value loss",
    "critic gradient",
    "value gradient",
    "actor gradient",
    "critic parameters",
    "value parameters",
    "actor parameters",
    "temperature",
)
"""The quantities that an update checks for divergence, in this order."""


class Rates(NamedTuple):
    """The numbers of the update rule."""

    gamma: np.float32
    tau: np.float32
    reward_scale: np.float32
    rate: float
    learns_temperature: bool
    target_entropy: np.float32
    """H"""


class Networks(NamedTuple):
    """The parameters that one run learns."""

    policy: Learned
    value: Learned
    critics: tuple[Learned, Learned]
    temperature: Learned
    """A single entry, log alpha in the unit of Q; unused where alpha is 1."""

    def state(self) -> State:
        """All of them by name."""
        first, second = self.critics
        return (
            within("policy", self.policy.state())
            | within("value", self.value.state())
            | within("critic 1", first.state())
            | within("critic 2", second.state())
            | within("temperature", self.temperature.state())
        )

    def restore(self, state: State) -> None:
        """Overwrite all of them."""
        first, second = self.critics
        self.policy.restore(part(state, "policy"))
        self.value.restore(part(state, "value"))
        first.restore(part(state, "critic 1"))
        second.restore(part(state, "critic 2"))
        self.temperature.restore(part(state, "temperature"))


class Shapes(NamedTuple):
    """The networks' sizes."""

    policy: Shape
    value: Shape
    critic: Shape


class Work(NamedTuple):
    """Arrays that an update overwrites."""

    batch: Batch
    policy: Pass
    actions: Array
    """[B, m]"""
    log_pi: Array
    """[B]"""
    policy_gradient: Array
    """[P]"""
    value: Pass
    value_aim: Array
    """[B], the target of V"""
    value_gradient: Array
    """[P]"""
    fit: CriticWork


class Report(NamedTuple):
    """The report of each of U updates, [U]; the mean of the two critics."""

    critic_loss: Array
    gradient_loss: Array
    value_loss: Array
    q_mean: Array
    """Mean of Q over the batch, in the unit of c r."""
    entropy: Array
    """Mean of -log pi."""
    temperature: Array
    """Alpha, in the unit of c r."""
    critic_gradient_norm: Array
    value_gradient_norm: Array
    actor_gradient_norm: Array
    target_mean: NDArray[np.float64]
    """Mean of the normalised targets of Q."""
    target_square: NDArray[np.float64]
    """Mean of their squares."""


def empty_report(updates: int) -> Report:
    """An empty report for `updates` updates."""
    return Report(*np.zeros((9, updates), np.float32), *np.zeros((2, updates)))


@compiled_fast
def new_work(memory: Memory, networks: Networks, rows: int, shapes: Shapes) -> Work:
    """Arrays for updates of `rows` transitions each."""
    theta = networks.policy.theta
    actions, columns = memory.actions.shape[1], memory.reward_gradients.shape[1]
    return Work(
        replay.new_batch(memory, rows),
        network.new_pass(theta, rows, shapes.policy),
        np.empty((rows, actions), theta.dtype),
        np.empty(rows, theta.dtype),
        np.empty_like(theta),
        network.new_pass(theta, rows, shapes.value),
        np.empty(rows, theta.dtype),
        np.empty_like(networks.value.theta),
        critic.new_critic_work(networks.critics[0].theta, rows, shapes.critic, columns),
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
    shapes: Shapes,
    report: Report,
) -> tuple[int, int]:
    """Update on the batches `indices [U, B]`, after `done` earlier updates.

    `noise [U, B, m]` is the noise of the sampled actions.

    Returns:
        As `algorithms.actor_critic.ddpg_update.update`.
    """
    work = new_work(memory, networks, indices.shape[1], shapes)
    for u in range(indices.shape[0]):
        matched = losses.due(matching, done + u)
        step = optimizer.corrected(rates.rate, done + u + 1)
        replay.draw(memory, indices[u], scaling, work.batch)
        replay.scale_rewards(work.batch, rates.reward_scale)
        if losses.is_matched(matched):
            replay.draw_derivatives(
                memory, indices[u], coordinates, scaling, work.batch, matched.shift
            )
            replay.scale_reward_gradients(work.batch, rates.reward_scale)
        aim_critics(networks.value, rates.gamma, scaling, matched, work, shapes)
        q_weight, entropy_weight = weights_of(networks, rates, scaling)
        improve_policy(networks, noise[u], q_weight, entropy_weight, work, shapes)
        report.value_loss[u] = fit_value(networks.value, work, shapes)
        report.temperature[u] = entropy_weight * (scaling.value_std / q_weight)
        describe(work, report, u)
        if rates.learns_temperature:
            learn_temperature(networks.temperature, rates.target_entropy, step, work)
        policy_norm, policy_size = optimizer.adam(networks.policy, work.policy_gradient, step)
        report.actor_gradient_norm[u] = np.sqrt(policy_norm)
        value_norm, value_size = optimizer.adam(networks.value, work.value_gradient, step)
        report.value_gradient_norm[u] = np.sqrt(value_norm)
        critic_size = work.log_pi.dtype.type(0)
        for learned in networks.critics:
            critic_size += fit_critic(
                learned, coordinates, scaling, matched, step, work, shapes, report, u
            )
        optimizer.follow(networks.value, rates.tau)
        lost = finite.first_not_finite((
            report.critic_loss[u], report.gradient_loss[u], report.value_loss[u],
            report.critic_gradient_norm[u], value_norm, policy_norm,
            critic_size, value_size, policy_size, entropy_weight,
        ))  # fmt: skip
        if lost >= 0:
            return u, lost
    return int(indices.shape[0]), -1


@compiled_fast
def aim_critics(
    value: Learned, gamma: Any, scaling: Scaling, matching: Matching, work: Work, shapes: Shapes
) -> None:
    """The critics' target and, where gradients are matched, its gradient."""
    following = Parameters(value.target, shapes.value)
    soft_bellman.target_value(following, work.batch, gamma, scaling, work.value, work.fit.value)
    if losses.is_matched(matching):
        soft_bellman.target_gradient(following, work.batch, gamma, work.value, work.fit.target)
        losses.blind(matching, work.fit.target)


@compiled_fast
def weights_of(networks: Networks, rates: Rates, scaling: Scaling) -> tuple[Any, Any]:
    """The weights of the normalised Q and of log pi in the policy's loss.

    With a fixed temperature, the loss is in the unit of c r; with a learned one, in that of Q.
    """
    real = networks.temperature.theta.dtype.type
    if rates.learns_temperature:
        return real(1), np.exp(networks.temperature.theta[0])
    return scaling.value_std, real(1)


@compiled_fast
def learn_temperature(learned: Learned, target_entropy: Any, step: Any, work: Work) -> None:
    """Step log alpha, after `improve_policy`."""
    gradient = np.empty_like(learned.theta)
    gradient[0] = -(work.log_pi.sum() / work.log_pi.size + target_entropy)
    optimizer.adam(learned, gradient, step)


@compiled_fast
def improve_policy(
    networks: Networks,
    noise: Array,
    q_weight: Any,
    entropy_weight: Any,
    work: Work,
    shapes: Shapes,
) -> None:
    """Compute the gradient of the policy's loss and the target of V."""
    batch, q = work.batch, work.fit.critic
    policy = Parameters(networks.policy.theta, shapes.policy)
    rows = batch.x.shape[0]
    real = work.log_pi.dtype.type
    share = real(1) / real(rows)
    network.receive(work.policy, batch.x)
    gaussian.sample(policy, work.policy, noise, work.actions, work.log_pi)
    critic.join(batch.x, work.actions, q.x)
    work.value_aim[:] = np.inf
    for k in range(2):
        # The first critic comes last: its pass is used for the backward pass.
        theta = networks.critics[1 - k].theta
        network.forward(Parameters(theta, shapes.critic), q)
        for row in range(rows):
            work.value_aim[row] = min(work.value_aim[row], q.out[row, 0])
    for row in range(rows):
        work.value_aim[row] -= entropy_weight * work.log_pi[row] / q_weight
        q.out_bar[row, 0] = -share * q_weight
    network.backward_to_input(Parameters(networks.critics[0].theta, shapes.critic), q)
    gaussian.pull_back(
        noise, work.actions, q.x_bar, batch.x.shape[1], share * entropy_weight, work.policy
    )
    network.backward(policy, work.policy)
    network.gradient(policy, work.policy, Parameters(work.policy_gradient, shapes.policy))


@compiled_fast
def fit_value(value: Learned, work: Work, shapes: Shapes) -> Any:
    """The loss of V; its gradient goes to `work.value_gradient`."""
    v = Parameters(value.theta, shapes.value)
    network.receive(work.value, work.batch.x)
    network.forward(v, work.value)
    loss = losses.value_loss(work.value.out, work.value_aim, work.value.out_bar)
    network.backward(v, work.value)
    network.gradient(v, work.value, Parameters(work.value_gradient, shapes.value))
    return loss


@compiled_fast
def fit_critic(
    learned: Learned,
    coordinates: Coordinates,
    scaling: Scaling,
    matching: Matching,
    step: Any,
    work: Work,
    shapes: Shapes,
    report: Report,
    u: int,
) -> Any:
    """Step one critic, add half of its numbers to the report; return its squared norm."""
    half = gaussian.HALF
    q = Parameters(learned.theta, shapes.critic)
    result = Parameters(work.fit.theta_gradient, shapes.critic)
    value_loss, gradient_loss = critic.fit(q, work.batch, coordinates, matching, work.fit, result)
    report.critic_loss[u] += half * value_loss
    report.gradient_loss[u] += half * gradient_loss
    q_mean = work.fit.critic.out.sum() / work.fit.value.size
    report.q_mean[u] += half * (scaling.value_mean + scaling.value_std * q_mean)
    norm, size = optimizer.adam(learned, work.fit.theta_gradient, step)
    report.critic_gradient_norm[u] += half * np.sqrt(norm)
    return size


@compiled_fast
def describe(work: Work, report: Report, u: int) -> None:
    """Report the entropy, and the moments of the critics' targets."""
    rows = work.log_pi.size
    entropy, total, square = 0.0, 0.0, 0.0
    for row in range(rows):
        entropy -= work.log_pi[row]
        total += work.fit.value[row]
        square += work.fit.value[row] * work.fit.value[row]
    report.entropy[u] = entropy / rows
    report.target_mean[u] = total / rows
    report.target_square[u] = square / rows


@compiled_fast
def gradient_pair(
    networks: Networks,
    memory: Memory,
    coordinates: Coordinates,
    scaling: Scaling,
    rates: Rates,
    shapes: Shapes,
) -> tuple[Array, Array]:
    """The first critic's gradient [B, C + m] and its target, at every transition of a memory."""
    indices = np.arange(memory.rewards.size)
    work = new_work(memory, networks, indices.size, shapes)
    replay.draw(memory, indices, scaling, work.batch)
    replay.scale_rewards(work.batch, rates.reward_scale)
    replay.draw_derivatives(memory, indices, coordinates, scaling, work.batch, 0)
    replay.scale_reward_gradients(work.batch, rates.reward_scale)
    v = Parameters(networks.value.target, shapes.value)
    q = Parameters(networks.critics[0].theta, shapes.critic)
    soft_bellman.target_value(v, work.batch, rates.gamma, scaling, work.value, work.fit.value)
    soft_bellman.target_gradient(v, work.batch, rates.gamma, work.value, work.fit.target)
    critic.own_gradient(q, work.batch, coordinates, work.fit)
    return work.fit.gradient, work.fit.target
