"""DDPG: deep deterministic policy gradients, as OpenAI Baselines ran it in the paper's day.

    Qhat  = r + gamma (1 - terminated) Q'(s', pi'(s'))
    critic   down   1/B sum (Q(s, a) - Qhat)^2 + decay / 2 |hidden products|^2
    actor    up     1/B sum Q(s, pi(s))
    targets  Q' += tau (Q - Q'),   pi' += tau (pi - pi')

A cycle is 100 environment steps under adaptive parameter noise, then 50 updates.

Sources: Lillicrap et al. (2015); OpenAI Baselines (Dhariwal et al., 2017), commit f49a9c3;
parameter noise, Plappert et al. (2017). Differences from Baselines:

- the critic returns a normalised Q, whose mean and standard deviation follow the targets seen in
  the replay; when they move, the output layers of Q and Q' are changed so that Q is not, and Adam's
  moments of both networks are those of the new unit (algorithms.networks.value_scale);
- the critic takes features and action side by side at its input (as Baselines did from September
  2018 on), and hidden units are tanh, not ReLU: the hybrid needs a smooth critic;
- weight decay is on hidden products alone (as Baselines from November 2018 on);
- the exploring actor is perturbed anew at each cycle, too
  (algorithms.actor_critic.parameter_noise);
- features have a standard-deviation floor of 0.001, not 0.1, and their statistics change with each
  cycle, not with each step;
- running out of time does not stop the bootstrap (`time_limit_is_terminal` brings that back);
- everything in float32 but the simulator and the statistics.
"""

from collections.abc import Sequence

import numpy as np

from algorithms.actor_critic.ddpg_update import (
    QUANTITIES,
    Rates,
    Report,
    empty_report,
    gradient_pair,
    update,
)
from algorithms.actor_critic.learner import OffPolicyLearner
from algorithms.actor_critic.parameter_noise import ParameterNoise, action_distance
from algorithms.early_end import NotFiniteQuantityError
from algorithms.experience.replay import Replay, check_finite, empty_memory
from algorithms.experience.rollout import Experience, Rollout
from algorithms.matching.diagnostics import UpdateMeans, agreement, with_derivatives
from algorithms.matching.losses import Matching, is_matched, matching_of
from algorithms.networks import network
from algorithms.networks.network import Shape
from algorithms.networks.optimizer import learned
from algorithms.networks.policy import Policy, deterministic
from algorithms.networks.scaling import Coordinates, Statistics, coordinates_of
from algorithms.networks.value_scale import move_value_scale, rescale_moments, rewrite_fit
from algorithms.settings import DDPGConfig
from algorithms.snapshot import Critic, Snapshot
from algorithms.state import State, part, within
from algorithms.stopwatch import Cost, Stopwatch
from physics.environment import Environment
from physics.randomness import generator

MEANS = (
    "critic_loss",
    "gradient_loss",
    "q_mean",
    "critic_gradient_norm",
    "actor_gradient_norm",
)


class DDPGAgent:
    """One run of DDPG, or of its hybrid; see `algorithms.actor_critic.learner.Agent`."""

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        matching: Matching,
        timesteps: int,
        config: DDPGConfig,
    ) -> None:
        """Draw the initial networks.

        Args:
            environment: the task.
            coordinates: of its features.
            seed: of the run.
            matching: of the critic's gradients.
            timesteps: of the whole run, which bounds its replay.
            config: the settings.
        """
        self.seed = seed
        self.updates = 0
        self.jacobians = 0
        self._environment = environment
        self._coordinates = coordinates
        self._config = config
        self._matching = matching
        self._matched = is_matched(matching)
        self._rates = Rates(
            np.float32(config.gamma),
            np.float32(config.tau),
            config.actor_rate,
            config.critic_rate,
            np.float32(config.critic_decay),
        )
        self._shapes = shapes_of(environment, config)
        actor, critic = self._shapes
        self._actor = learned(network.initial(actor, generator(seed, "actor")))
        self._critic = learned(network.initial(critic, generator(seed, "critic")))
        self._statistics = Statistics(coordinates, environment.action_size)
        self._perturbations = 0
        self._noise = ParameterNoise(config.noise, network.noisy_size(actor))
        capacity = min(config.replay_size, timesteps)
        memory = empty_memory(capacity, environment, coordinates, linearized=self._matched)
        self.replay = Replay(memory, environment.state_size)
        self._means = UpdateMeans(MEANS)

    def policy(self) -> Policy:
        """The deterministic policy learned so far."""
        scaling = self._statistics.scaling()
        m = self._environment.action_size
        return deterministic(self._actor.theta, scaling.mean, scaling.inverse, m)

    def exploring_policy(self) -> Policy:
        """A newly perturbed actor."""
        noise = generator(self.seed, "parameter noise", self._perturbations)
        self._perturbations += 1
        return self.policy()._replace(theta=self._noise.perturbed(self._actor.theta, noise))

    def remember(self, experience: Experience) -> None:
        """Store the transitions and take in their features."""
        transitions = experience.transitions
        check_finite(transitions)
        self._statistics.observe(np.ascontiguousarray(transitions.features))
        self._statistics.observe_rewards(transitions.rewards.astype(np.float64))
        self.replay.extend(transitions, experience.states)
        self.jacobians += len(experience.states) if self._matched else 0

    def learn(self) -> None:
        """Adapt the noise, update both networks, move the critic's output unit."""
        count, batch = self._config.cycle_updates, self._config.batch_size
        self._adapt_noise()
        draws = generator(self.seed, "batches", self.updates)
        indices = draws.integers(self.replay.size, size=(count, batch))
        report = empty_report(count)
        done, lost = update(
            self._actor, self._critic, self.updates, self.replay.memory, indices,
            self._coordinates, self._statistics.scaling(), self._rates, self._matching,
            self._shapes, report,
        )  # fmt: skip
        self.updates += done
        if lost >= 0:
            raise NotFiniteQuantityError(QUANTITIES[lost])
        self._move_value_scale(report)
        self._means.add(report)

    def diagnose(self, timestep: int) -> dict[str, float]:
        """The means of the updates since the last call, and how well gradients fit."""
        draws = generator(self.seed, "diagnostics", timestep)
        indices = draws.integers(self.replay.size, size=self._config.batch_size)
        drawn = with_derivatives(self._environment, self._coordinates, self.replay, indices)
        self.jacobians += len(indices)
        gradient, target = gradient_pair(
            self._actor, self._critic, drawn, self._coordinates, self._statistics.scaling(),
            self._rates.gamma, self._shapes,
        )  # fmt: skip
        return {
            **self._means.take(),
            **agreement(gradient, target, self._coordinates),
            "noise_scale": self._noise.scale,
            "value_std": self._statistics.value_std,
        }

    def state(self) -> State:
        """All that its next bits depend on but the replay."""
        own = {
            "updates": np.array(self.updates),
            "jacobians": np.array(self.jacobians),
            "perturbations": np.array(self._perturbations),
            "noise_scale": np.array(self._noise.scale),
        }
        return (
            own
            | within("actor", self._actor.state())
            | within("critic", self._critic.state())
            | within("statistics", self._statistics.state())
            | within("means", self._means.state())
        )

    def restore(self, state: State) -> None:
        """Take up what `state` gave."""
        self.updates = int(state["updates"])
        self.jacobians = int(state["jacobians"])
        self._perturbations = int(state["perturbations"])
        self._noise.scale = float(state["noise_scale"])
        self._actor.restore(part(state, "actor"))
        self._critic.restore(part(state, "critic"))
        self._statistics.restore(part(state, "statistics"))
        self._means.restore(part(state, "means"))

    def snapshot(self, timestep: int) -> Snapshot:
        """What was learned so far."""
        statistics = self._statistics
        return Snapshot(
            timestep,
            self._config.hidden_units,
            self._environment.action_size,
            self.policy(),
            Critic(self._critic.theta, statistics.value_mean, statistics.value_std),
        )

    def _adapt_noise(self) -> None:
        """Measure what a fresh perturbation does to the actions, and follow it."""
        draws = generator(self.seed, "noise adaptation", self.updates)
        perturbed = self._noise.perturbed(self._actor.theta, draws)
        indices = draws.integers(self.replay.size, size=self._config.batch_size)
        distance = action_distance(
            self._actor.theta, perturbed, self.replay.memory, indices,
            self._statistics.scaling(), self._shapes[0],
        )  # fmt: skip
        self._noise.adapt(float(distance))

    def _move_value_scale(self, report: Report) -> None:
        """Set the unit of Q to the cycle's targets, leaving Q and Q' as they are."""
        change = move_value_scale(
            self._statistics, report.target_mean.mean(), report.target_square.mean()
        )
        rewrite_fit(self._critic, self._shapes[1], change)
        rescale_moments(self._actor, np.float32(change.ratio))  # it climbs the normalised Q


def shapes_of(environment: Environment, config: DDPGConfig) -> tuple[Shape, Shape]:
    """The sizes of the actor and of the critic."""
    features, actions = environment.feature_size, environment.action_size
    return (
        Shape(features, config.hidden_units, actions),
        Shape(features + actions, config.hidden_units, 1),
    )


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: DDPGConfig,
) -> OffPolicyLearner:
    """A cohort of DDPG runs; with weights other than 0, of its hybrid (L2)."""
    return cohort(environment, seeds, matching_of(weights, by_cosine=False), timesteps, config)


def build_cosine(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: DDPGConfig,
) -> OffPolicyLearner:
    """A cohort of runs of DDPG's hybrid that matches the gradients' directions."""
    return cohort(environment, seeds, matching_of(weights, by_cosine=True), timesteps, config)


def cohort(
    environment: Environment,
    seeds: Sequence[int],
    matching: Matching,
    timesteps: int,
    config: DDPGConfig,
) -> OffPolicyLearner:
    """A cohort of runs whose critics match gradients as given."""
    coordinates = coordinates_of(environment)
    stopwatch = Stopwatch({seed: Cost() for seed in seeds})
    with stopwatch.aside():
        agents = [
            DDPGAgent(environment, coordinates, seed, matching, timesteps, config) for seed in seeds
        ]
        rollout = Rollout(
            environment, coordinates, seeds,
            linearized=is_matched(matching),
            time_limit_is_terminal=config.time_limit_is_terminal,
        )  # fmt: skip
    return OffPolicyLearner(
        environment, agents, rollout, agents[0]._shapes[0],
        stopwatch=stopwatch, timesteps=timesteps, rollout_steps=config.rollout_steps,
    )  # fmt: skip
