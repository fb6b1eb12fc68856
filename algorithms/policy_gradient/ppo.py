"""PPO: proximal policy optimisation, for a cohort of runs; a reference without derivatives.

    A       = R - V(s),   R TD(lambda)'s return: the generalised advantage estimate
    actor   down  -mean min(ratio A, clip(ratio, 1 - bound, 1 + bound) A)
    critic  down  mean (V(s) - R)^2

Each update takes a window of T steps in E environments, then goes through it in several epochs
of small batches, each in a new order, with advantages normalised in each batch
(algorithms.policy_gradient.ppo_update). Both networks' gradients are bounded in norm, and the
learning rate falls to 0 by the run's end. An episode that a time limit ends has the value V there;
one that the task ends has the value 0.

Sources: Schulman et al. (2017), "Proximal policy optimization algorithms"; Huang et al. (2022),
"The 37 implementation details of proximal policy optimization", for continuous actions.
Differences:

- actions are tanh u of a Gaussian u, not clipped; the ratio is that of u, since tanh does not
  change it;
- the networks are those of every learner here, 64-64 tanh units with layer normalisation and small
  last layers, not orthogonal ones;
- values have a unit that follows their targets (algorithms.networks.value_scale), in place of
  rewards divided by a running standard deviation and clipped at 10;
- the value's change is not clipped, and there is no bonus for entropy: clipping does not help in
  continuous control (Andrychowicz et al., 2021), and the bonus is 0 there;
- actor and critic are fitted one after the other, each with its own bound on the gradient's norm
  and its own order of rows; this has no other effect, since they share no parameters;
- Adam's epsilon is 1e-8, not 1e-5; the default window is 8 environments of 256 steps, not one of
  2,048; features are clipped at 5 deviations, not 10; log sigma lies within [-20, 2].
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.optimizer import USUAL
from algorithms.networks.scaling import Scaling
from algorithms.networks.value_scale import UnitChange
from algorithms.on_policy.run import Moment, Networks, Outlook, Report, lost_of
from algorithms.on_policy.values import (
    Epochs,
    epochs_of,
    evaluate,
    fit,
    lambda_returns,
    normalised,
)
from algorithms.on_policy.window import Window
from algorithms.on_policy.window_learner import WindowLearner
from algorithms.policy_gradient.ppo_update import improve
from algorithms.settings import PPOConfig
from physics.environment import Environment

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]


class Means(NamedTuple):
    """The report of an update."""

    critic_loss: np.float64
    v_mean: np.float64
    """Mean of V over the window, in the task's units."""
    critic_gradient_norm: np.float64
    actor_gradient_norm: np.float64
    clipped: np.float64
    """Share of rows without a gradient, because of the bound."""
    policy_distance: np.float64
    """Mean divergence of the policy from the one that took the steps."""


class PPO:
    """How PPO learns from a window; see `algorithms.on_policy.run.Rule`."""

    linearized = False
    means: Sequence[str] = Means._fields

    def __init__(self, config: PPOConfig) -> None:
        """Learn with these settings."""
        self._config = config

    def look_ahead(self, networks: Networks, window: Window, scaling: Scaling) -> Outlook:
        """The values V of the window's states, and returns with those of the next states."""
        critic, shape = networks.critic, networks.critic_shape
        values, next_values, returns = (np.empty_like(window.rewards) for _ in range(3))
        evaluate(critic.theta, shape, scaling, window.features, values)
        evaluate(critic.theta, shape, scaling, window.next_features, next_values)
        lambda_returns(
            window.rewards, next_values, window.terminated, window.is_last,
            self._config.gamma, self._config.trace, returns,
        )  # fmt: skip
        return Outlook(returns, values, np.zeros((0, 0, 0)))

    def learn(self, networks: Networks, window: Window, outlook: Outlook, moment: Moment) -> Report:
        """Fit the actor to the window, then the critic."""
        critic, shape, scaling = networks.critic, networks.critic_shape, moment.scaling
        returns, values, _ = outlook
        x = evaluate(critic.theta, shape, scaling, window.features, np.empty_like(values))
        advantages = (returns - values) / np.float64(scaling.value_std)
        seen = improve(
            networks.actor, networks.actor_shape, x,
            window.noise.reshape(-1, window.noise.shape[2]),
            advantages.ravel().astype(np.float32),
            np.float32(self._config.ratio_bound), self._epochs(moment, values.size),
        )  # fmt: skip
        how = self._epochs(moment, values.size)
        loss, norm, size = fit(critic, shape, x, normalised(returns, scaling), how)
        lost = lost_of({
            "actor gradient": seen.gradient_norm,
            "actor parameters": seen.size,
            "critic loss": loss,
            "critic gradient": norm,
            "critic parameters": size,
        })  # fmt: skip
        told = loss, values.mean(), norm, seen.gradient_norm, seen.clipped, seen.divergence
        return Report(Means(*map(np.float64, told)), lost)

    def change_unit(self, networks: Networks, change: UnitChange) -> None:
        """Do nothing: with normalised advantages, the actor does not depend on the unit."""

    def _epochs(self, moment: Moment, size: int) -> Epochs:
        rate = self._config.rate * (1.0 - moment.progress)
        return epochs_of(
            moment, size, self._config.epochs, self._config.batches, rate, self._config.clip, USUAL
        )


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: PPOConfig,
) -> WindowLearner:
    """A cohort of PPO runs, which do not use the weights."""
    del weights
    return WindowLearner(environment, seeds, timesteps, config, PPO(config))
