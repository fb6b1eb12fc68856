"""SHAC: short-horizon actor-critic, for a cohort of runs.

    J       = 1/E sum over stretches of  sum_i gamma^i r_i + gamma^h c V'(s_h)
    actor   up    dJ/dtheta, exact, through the simulator             (algorithms.ascent.pathwise)
    critic  down  mean over the window of  (V(s) - R)^2, several epochs
    target  V' keeps a share of itself and takes the rest from V
    R       TD(lambda)'s return, of V'                               (algorithms.on_policy.values)

Each update takes a window of T steps in E environments with a = tanh(mu(s) + sigma e), with the
noise e held constant: J is reparameterised, and sigma is learned with the rest. A stretch of a
window is the part of one episode in it: h steps, then V', also for an episode that a time limit
ends, but c = 0 where the task has ended. A window continues where the one before ended, and
gradients stop there: a long episode is optimised in pieces that are short enough for the product of
their Jacobians not to be chaotic.

Where the task's rewards have no gradient, as on Acrobot, the rewards of a window do not affect the
actor, which then climbs only the value at their end, through the Jacobians of the steps: SHAC does
not refuse such a task, but has less to learn from.

Source: Xu et al. (2022), "Accelerated policy learning with parallel differentiable simulation", and
the authors' code, NVlabs/DiffRL, `algorithms/shac.py`. Differences:

- the networks are those of every learner here (algorithms.networks.network), 64-64 ELU units for
  both, layer normalisation before the activation and not after it, small last layers; not 128-64-32
  and 64-64, with orthogonal first weights;
- values have a unit that follows their targets, and J is in that unit, and is a sum over the
  window, not its mean. So the bound on gradients' norms does not depend on the unit of rewards;
- features are normalised by the statistics of all earlier windows;
- each epoch of the critic has its own order of rows, and rows that do not fill a batch are skipped;
- log sigma lies within [-20, 2];
- learning rates fall by timesteps, from window to window.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.ascent.pathwise import Linearized, Stretches, ascent_direction
from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.optimizer import (
    Betas,
    Learned,
    clipped_step,
    corrected_for,
    follow,
)
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Scaling
from algorithms.networks.shape import Shape
from algorithms.networks.value_scale import UnitChange, rescale_moments
from algorithms.on_policy.actor import is_free
from algorithms.on_policy.run import Moment, Networks, Outlook, Report, lost_of
from algorithms.on_policy.values import (
    Floats,
    Integers,
    epochs_of,
    evaluate,
    evaluate_with_gradient,
    fit,
    lambda_returns,
    normalised,
)
from algorithms.on_policy.window import Window
from algorithms.on_policy.window_learner import WindowLearner
from algorithms.settings import SHACConfig
from physics.environment import Environment
from physics.kernels.compiled import compiled_fast

BETAS = Betas(0.7, 0.95)
LAST_RATE = 1e-5
"""The learning rates at the end of a run."""


class Means(NamedTuple):
    """The report of an update."""

    critic_loss: np.float64
    v_mean: np.float64
    """Mean of the target's values at the states that steps led to, in the task's units."""
    critic_gradient_norm: np.float64
    actor_gradient_norm: np.float64


class SHAC:
    """How SHAC learns from a window; see `algorithms.on_policy.run.Rule`."""

    linearized = True
    means: Sequence[str] = Means._fields

    def __init__(self, environment: Environment, config: SHACConfig) -> None:
        """Learn on this task, with these settings."""
        self._environment = environment
        self._config = config

    def look_ahead(self, networks: Networks, window: Window, scaling: Scaling) -> Outlook:
        """The values V' of the states that steps led to, their gradients and the returns."""
        values, returns = np.empty_like(window.rewards), np.empty_like(window.rewards)
        beyond = np.zeros((*values.shape, self._environment.state_size))
        evaluate_with_gradient(
            networks.critic.target, networks.critic_shape, scaling,
            self._environment.feature_sources, window.next_features,
            self._slopes(window.next_features), values, beyond,
        )  # fmt: skip
        beyond[window.terminated] = 0.0
        lambda_returns(
            window.rewards, values, window.terminated, window.is_last,
            self._config.gamma, self._config.trace, returns,
        )  # fmt: skip
        return Outlook(returns, values, beyond)

    def learn(self, networks: Networks, window: Window, outlook: Outlook, moment: Moment) -> Report:
        """Step the actor, then fit the critic, both with the target before the update."""
        norm, size = self._climb(networks, window, moment, outlook.beyond)
        lost = lost_of({"actor gradient": norm, "actor parameters": size})
        if lost:
            return Report(None, lost)
        loss, critic_norm, critic_size = self._fit(networks, window, moment, outlook.returns)
        lost = lost_of({
            "critic loss": loss,
            "critic gradient": critic_norm,
            "critic parameters": critic_size,
        })  # fmt: skip
        told = loss, outlook.values.mean(), critic_norm, norm
        return Report(Means(*map(np.float64, told)), lost)

    def change_unit(self, networks: Networks, change: UnitChange) -> None:
        """Rescale the actor's moments, since it climbs J in that unit."""
        rescale_moments(networks.actor, np.float32(change.ratio))

    def _climb(
        self, networks: Networks, window: Window, moment: Moment, beyond: Floats
    ) -> tuple[float, float]:
        """Step the actor; return its gradient's norm and the squared norm of its parameters."""
        steps, columns = window.rewards.shape
        linearized = Linearized._make([
            window.features, self._slopes(window.features), window.rewards,
            *window.derivatives, np.full(columns, steps),
        ])  # fmt: skip
        weights = discounts(window.is_last, self._config.gamma) / moment.scaling.value_std
        stretches = Stretches(window.is_last, beyond, weights, self._config.gamma)
        rate = self._rate(self._config.actor_rate, moment)
        norm, size = climb(
            networks.actor, networks.actor_shape, moment.scaling,
            self._environment.feature_sources, linearized, stretches,
            window.noise.reshape(-1, window.noise.shape[2]),
            self._config.clip, corrected_for(BETAS, rate, moment.done + 1),
        )  # fmt: skip
        return float(norm), float(size)

    def _fit(
        self, networks: Networks, window: Window, moment: Moment, returns: Floats
    ) -> tuple[float, float, float]:
        """Fit the critic and let the target follow; return as `fit`."""
        rate = self._rate(self._config.critic_rate, moment)
        how = epochs_of(
            moment, returns.size, self._config.critic_epochs, self._config.critic_batches, rate,
            self._config.clip, BETAS,
        )  # fmt: skip
        critic, shape, scaling = networks.critic, networks.critic_shape, moment.scaling
        x = evaluate(critic.theta, shape, scaling, window.features, np.empty_like(returns))
        told = fit(critic, shape, x, normalised(returns, scaling), how)
        follow(critic, np.float32(1.0 - self._config.target_share))
        return told

    def _rate(self, first: float, moment: Moment) -> float:
        return first + (LAST_RATE - first) * moment.progress

    def _slopes(self, features: Floats) -> Floats:
        rows = features.reshape(-1, features.shape[2])
        slopes: Floats = self._environment.feature_slopes(rows)
        return slopes.reshape(features.shape)


def discounts(is_last: NDArray[np.bool_], gamma: float) -> Floats:
    """`gamma^i` [T, E] of each step in its stretch."""
    weights = np.ones(is_last.shape)
    for t in range(1, len(is_last)):
        weights[t] = np.where(is_last[t - 1], 1.0, gamma * weights[t - 1])
    return weights


@compiled_fast
def climb(
    actor: Learned,
    shape: Shape,
    scaling: Scaling,
    sources: Integers,
    linearized: Linearized,
    stretches: Stretches,
    noise: Array,
    bound: float,
    step: Any,
) -> tuple[Any, Any]:
    """Step the actor up J; return as `clipped_step`."""
    gradient = np.empty_like(actor.theta)
    work = network.new_pass(actor.theta, noise.shape[0], shape)
    ascent_direction(
        Parameters(actor.theta, shape), work, scaling.mean, scaling.inverse, sources, linearized,
        stretches, noise, Parameters(gradient, shape),
    )  # fmt: skip
    spread_gradient(actor.theta, work.out_bar, noise, gradient)
    for i in range(gradient.size):
        gradient[i] = -gradient[i]
    return clipped_step(actor, gradient, bound, step, BETAS)


@compiled_fast
def spread_gradient(theta: Array, mean_bar: Array, noise: Array, gradient: Array) -> None:
    """Set the gradient of log sigma, the last m: that of mu, `mean_bar`, times sigma e, summed."""
    m = noise.shape[1]
    for k in range(m):
        total = noise.dtype.type(0)
        for row in range(noise.shape[0]):
            total += mean_bar[row, k] * noise[row, k]
        free = is_free(theta[theta.size - m + k])
        gradient[theta.size - m + k] = total if free else noise.dtype.type(0)


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: SHACConfig,
) -> WindowLearner:
    """A cohort of SHAC runs, which do not use the weights."""
    del weights
    return WindowLearner(environment, seeds, timesteps, config, SHAC(environment, config))
