"""DDPG: deep deterministic policy gradients, as in OpenAI Baselines at the time of the paper.

    Qhat  = r + gamma (1 - terminated) Q'(s', pi'(s'))
    critic   down   1/B sum (Q(s, a) - Qhat)^2 + decay / 2 |hidden products|^2
    actor    up     1/B sum Q(s, pi(s))
    targets  Q' += tau (Q - Q'),   pi' += tau (pi - pi')

A cycle is 100 environment steps under adaptive parameter noise, then 50 updates.

Sources: Lillicrap et al. (2015); OpenAI Baselines (Dhariwal et al., 2017), commit f49a9c3;
parameter noise, Plappert et al. (2017). Differences from Baselines:

- the critic returns a normalised Q, whose mean and standard deviation follow the targets seen in
  the replay; when they change, the output layers of Q and Q' are adapted so that Q stays the same,
  and Adam's moments of both networks are converted to the new unit
  (algorithms.networks.value_scale);
- the critic takes features and action side by side at its input (as Baselines did from September
  2018 on), and hidden units are tanh, not ReLU: the hybrid needs a smooth critic;
- weight decay applies to hidden products alone (as in Baselines from November 2018 on);
- the exploring actor is perturbed again at each cycle, too
  (algorithms.actor_critic.parameter_noise);
- features have a standard-deviation floor of 0.001, not 0.1, and their statistics change with each
  cycle, not with each step;
- a time limit does not stop the bootstrap (`time_limit_is_terminal` restores that);
- everything is in float32 except the simulator and the statistics.
"""

from collections.abc import Sequence

import numpy as np

from algorithms.actor_critic.agent import Cycle
from algorithms.actor_critic.ddpg_update import Rates, gradient_pair, update
from algorithms.actor_critic.deterministic import MEANS, QUANTITIES, Report, empty_report
from algorithms.actor_critic.learner import OffPolicyLearner, cohort
from algorithms.actor_critic.parameter_noise import ParameterNoise, action_distance
from algorithms.experience.replay import Memory
from algorithms.matching.losses import COSINE, L2, ROBUST, Matching, matching_of
from algorithms.networks.layer import Array
from algorithms.networks.optimizer import learned
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policy
from algorithms.networks.scaling import Coordinates, Scaling
from algorithms.networks.shape import Shape, noisy_size, shape_of
from algorithms.networks.value_scale import UnitChange, rescale_moments, rewrite_fit
from algorithms.settings import DDPGConfig
from algorithms.state import State, part, within
from physics.environment import Environment
from physics.randomness import generator


class DDPG:
    """The networks of DDPG and of its hybrids; see `algorithms.actor_critic.agent.ActorCritic`."""

    means: Sequence[str] = MEANS
    quantities: Sequence[str] = QUANTITIES

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        matching: Matching,
        config: DDPGConfig,
    ) -> None:
        """Draw the initial networks."""
        self.reward_scale = 1.0
        self.actor_shape, self._critic_shape = shapes_of(environment, config)
        self.actor = learned(initial_theta(self.actor_shape, generator(seed, "actor")))
        self.critic = learned(initial_theta(self._critic_shape, generator(seed, "critic")))
        self._seed = seed
        self._coordinates = coordinates
        self._matching = matching
        self._rates = Rates(
            np.float32(config.gamma),
            np.float32(config.tau),
            config.actor_rate,
            config.critic_rate,
            np.float32(config.critic_decay),
        )
        self._perturbations = 0
        self._noise = ParameterNoise(config.noise, noisy_size(self.actor_shape))

    def explorer(self, policy: Policy) -> Policy:
        """A newly perturbed actor."""
        noise = generator(self._seed, "parameter noise", self._perturbations)
        self._perturbations += 1
        return policy._replace(theta=self._noise.perturbed(policy.theta, noise))

    def update(self, cycle: Cycle) -> tuple[int, int, Report]:
        """Adapt the noise, then update both networks."""
        self._adapt_noise(cycle)
        report = empty_report(len(cycle.indices))
        done, lost = update(
            self.actor, self.critic, cycle.done, cycle.replay.memory, cycle.indices,
            self._coordinates, cycle.scaling, self._rates, self._matching,
            (self.actor_shape, self._critic_shape), report,
        )  # fmt: skip
        return done, lost, report

    def change_unit(self, change: UnitChange) -> None:
        """Leave Q and Q' as they are; the actor climbs the normalised Q."""
        rewrite_fit(self.critic, self._critic_shape, change)
        rescale_moments(self.actor, np.float32(change.ratio))

    def gradient_pair(self, memory: Memory, scaling: Scaling) -> tuple[Array, Array]:
        """The critic's gradient [B, C + m] and its target, at every transition of a memory."""
        return gradient_pair(
            self.actor, self.critic, memory, self._coordinates, scaling,
            self._rates.gamma, (self.actor_shape, self._critic_shape),
        )  # fmt: skip

    def diagnostics(self) -> dict[str, float]:
        """The standard deviation of the parameter noise."""
        return {"noise_scale": self._noise.scale}

    def state(self) -> State:
        """The networks and the noise."""
        return {
            "perturbations": np.array(self._perturbations),
            "noise_scale": np.array(self._noise.scale),
            **within("actor", self.actor.state()),
            **within("critic", self.critic.state()),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        self._perturbations = int(state["perturbations"])
        self._noise.scale = float(state["noise_scale"])
        self.actor.restore(part(state, "actor"))
        self.critic.restore(part(state, "critic"))

    def _adapt_noise(self, cycle: Cycle) -> None:
        """Adapt the scale of the noise to the action distance of a new perturbation."""
        draws = generator(self._seed, "noise adaptation", cycle.done)
        perturbed = self._noise.perturbed(self.actor.theta, draws)
        indices = draws.integers(cycle.replay.size, size=cycle.indices.shape[1:])
        distance = action_distance(
            self.actor.theta, perturbed, cycle.replay.memory, indices,
            cycle.scaling, self.actor_shape,
        )  # fmt: skip
        self._noise.adapt(float(distance))


def shapes_of(environment: Environment, config: DDPGConfig) -> tuple[Shape, Shape]:
    """The sizes of the actor and of the critic."""
    features, actions = environment.feature_size, environment.action_size
    return (
        shape_of(features, actions, config),
        shape_of(features + actions, 1, config),
    )


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: DDPGConfig,
) -> OffPolicyLearner:
    """A cohort of DDPG runs; with weights other than 0, of its hybrid (L2)."""
    return matching_cohort(environment, seeds, weights, L2, timesteps, config)


def build_cosine(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: DDPGConfig,
) -> OffPolicyLearner:
    """A cohort of runs of DDPG's hybrid that matches the gradients' directions."""
    return matching_cohort(environment, seeds, weights, COSINE, timesteps, config)


def build_robust(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: DDPGConfig,
) -> OffPolicyLearner:
    """A cohort of runs of DDPG's hybrid with the robust loss."""
    return matching_cohort(environment, seeds, weights, ROBUST, timesteps, config)


def matching_cohort(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    loss: int,
    timesteps: int,
    config: DDPGConfig,
) -> OffPolicyLearner:
    """A cohort of runs whose critics match gradients by this loss."""
    matching = matching_of(weights, loss, config.placebo, config.match_every)
    terminal = config.time_limit_is_terminal
    return cohort(
        DDPG, environment, seeds, matching, timesteps, config, time_limit_is_terminal=terminal
    )
