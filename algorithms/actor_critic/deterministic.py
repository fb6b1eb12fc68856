"""The shared parts of the updates of DDPG and TD3: the actor's step and the report."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.matching import critic
from algorithms.networks import actor, network
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Scaling
from physics.kernels.compiled import compiled_fast

QUANTITIES = (
    "critic loss",
    "gradient loss",
    "critic gradient",
    "actor gradient",
    "critic parameters",
    "actor parameters",
)
"""The quantities that an update checks for divergence, in this order."""
MEANS = (
    "critic_loss",
    "gradient_loss",
    "q_mean",
    "critic_gradient_norm",
    "actor_gradient_norm",
)
"""The fields of a report that are reported as means."""


class Report(NamedTuple):
    """The report of each of U updates, [U]; the mean of several critics."""

    critic_loss: Array
    gradient_loss: Array
    q_mean: Array
    """Mean of the critic's Q over the batch, in the task's units."""
    critic_gradient_norm: Array
    actor_gradient_norm: Array
    target_mean: NDArray[np.float64]
    """Mean of the normalised targets."""
    target_square: NDArray[np.float64]
    """Mean of their squares."""


def empty_report(updates: int) -> Report:
    """An empty report for `updates` updates."""
    single, double = np.zeros((5, updates), np.float32), np.zeros((2, updates))
    return Report(single[0], single[1], single[2], single[3], single[4], double[0], double[1])


@compiled_fast
def actor_gradient(
    pi: Parameters,
    q: Parameters,
    x: Array,
    actor_work: Pass,
    critic_work: Pass,
    actions: Array,
    result: Parameters,
) -> None:
    """The gradient of `-1/B sum Q(s, pi(s))` at features `x [B, F]`; pi(s) goes to `actions`."""
    real = x.dtype.type
    network.receive(actor_work, x)
    actor.choose(pi, actor_work, actions)
    critic.join(x, actions, critic_work.x)
    network.forward(q, critic_work)
    critic_work.out_bar[:] = -real(1) / real(x.shape[0])
    network.backward_to_input(q, critic_work)
    actor.pull_back(actions, critic_work.x_bar, x.shape[1], actor_work)
    network.backward(pi, actor_work)
    network.gradient(pi, actor_work, result)


@compiled_fast
def describe(q: Array, value: Array, share: Any, scaling: Scaling, report: Report, u: int) -> None:
    """Add `share` of the mean of `q [B, 1]`; note the moments of the targets `value [B]`."""
    rows = value.size
    q_sum, target_sum, square_sum = 0.0, 0.0, 0.0
    for row in range(rows):
        q_sum += q[row, 0]
        target_sum += value[row]
        square_sum += value[row] * value[row]
    report.q_mean[u] += share * (scaling.value_mean + scaling.value_std * q_sum / rows)
    report.target_mean[u] = target_sum / rows
    report.target_square[u] = square_sum / rows
