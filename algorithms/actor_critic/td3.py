"""TD3: twin delayed deterministic policy gradients, and its hybrid.

    a'       = clip(pi'(s') + clip(N(0, 0.2), -0.5, 0.5), -1, 1)
    Qhat     = r + gamma (1 - terminated) min(Q1', Q2')(s', a')
    Q1, Q2   down   1/B sum (Q(s, a) - Qhat)^2
    actor    up     1/B sum Q1(s, pi(s)),                                   every second update
    targets  Q' += tau (Q - Q'),   pi' += tau (pi - pi'),                   every second update

It explores with uniform actions for the first 1,000 steps, then with noise N(0, 0.1) on each action
of its policy. The hybrid adds to both critics' losses the robust gradient loss
(algorithms.matching.losses) against the gradient of Qhat, that is, of the lesser Q'.

Sources: Fujimoto et al. (2018), "Addressing function approximation error in actor-critic methods",
and the authors' code, commit 6a9f761. Differences:

- the networks are those of every learner here (algorithms.networks.network): 64-64 tanh units with
  layer normalisation, small last layers; not 256-256 ReLU. Batches are of 64, not 256;
- features are normalised, and both critics' unit follows their targets
  (algorithms.networks.value_scale);
- a cycle is some environment steps, then some updates; they do not alternate step by step. Updates
  begin with the first cycle; in the authors' code, after the uniform actions;
- everything is in float32 except the simulator and the statistics.
"""

from collections.abc import Sequence

import numpy as np

from algorithms.actor_critic.agent import Cycle
from algorithms.actor_critic.deterministic import MEANS, QUANTITIES, Report, empty_report
from algorithms.actor_critic.learner import OffPolicyLearner, cohort
from algorithms.actor_critic.td3_update import Networks, Rates, gradient_pair, update
from algorithms.experience.replay import Memory
from algorithms.matching.losses import ROBUST, Matching, matching_of
from algorithms.networks.layer import Array
from algorithms.networks.optimizer import learned
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policy, uniform
from algorithms.networks.scaling import Coordinates, Scaling
from algorithms.networks.shape import shape_of
from algorithms.networks.value_scale import UnitChange, rescale_moments, rewrite_fit
from algorithms.settings import TD3Config
from algorithms.state import State, part, within
from physics.environment import Environment
from physics.randomness import generator


class TD3:
    """The networks of TD3 and of its hybrid; see `algorithms.actor_critic.agent.ActorCritic`."""

    means: Sequence[str] = MEANS
    quantities: Sequence[str] = QUANTITIES

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        matching: Matching,
        config: TD3Config,
    ) -> None:
        """Draw the initial networks."""
        features, m = environment.feature_size, environment.action_size
        self.reward_scale = 1.0
        self.actor_shape = shape_of(features, m, config)
        self._critic_shape = shape_of(features + m, 1, config)
        self.actor = learned(initial_theta(self.actor_shape, generator(seed, "actor")))
        first, second = (
            learned(initial_theta(self._critic_shape, generator(seed, "critic", k)))
            for k in range(2)
        )
        self._networks = Networks(self.actor, (first, second))
        self.critic = first
        self._seed = seed
        self._coordinates = coordinates
        self._matching = matching
        self._rates = Rates(
            np.float32(config.gamma),
            np.float32(config.tau),
            config.actor_rate,
            config.critic_rate,
            np.float32(config.target_noise),
            np.float32(config.noise_bound),
            config.delay,
        )
        self._noise = np.float32(config.noise)
        self._noise_shape = config.rollout_steps, m
        self._explorations = 0
        self._uniform_steps = config.uniform_steps
        self._steps = 0

    def explorer(self, policy: Policy) -> Policy:
        """Uniform actions at first, then the policy with noise, drawn for a cycle."""
        draws = generator(self._seed, "exploration", self._explorations)
        self._explorations += 1
        if self._steps < self._uniform_steps:
            return uniform(policy, self.actor_shape, self._noise_shape, draws)
        noise = self._noise * draws.standard_normal(self._noise_shape, np.float32)
        return policy._replace(noise=noise)

    def update(self, cycle: Cycle) -> tuple[int, int, Report]:
        """Update both critics and, at intervals, the actor."""
        self._steps = cycle.replay.count
        actions = self._noise_shape[1]
        noise = cycle.draws.standard_normal((*cycle.indices.shape, actions), np.float32)
        report = empty_report(len(cycle.indices))
        done, lost = update(
            self._networks, cycle.done, cycle.replay.memory, cycle.indices, noise,
            self._coordinates, cycle.scaling, self._rates, self._matching,
            (self.actor_shape, self._critic_shape), report,
        )  # fmt: skip
        return done, lost, report

    def change_unit(self, change: UnitChange) -> None:
        """Leave all Q as they are; the actor climbs the normalised Q."""
        for critic in self._networks.critics:
            rewrite_fit(critic, self._critic_shape, change)
        rescale_moments(self.actor, np.float32(change.ratio))

    def gradient_pair(self, memory: Memory, scaling: Scaling) -> tuple[Array, Array]:
        """The first critic's gradient [B, C + m] and its target."""
        return gradient_pair(
            self._networks, memory, self._coordinates, scaling, self._rates, self._matching,
            (self.actor_shape, self._critic_shape),
        )  # fmt: skip

    def diagnostics(self) -> dict[str, float]:
        """No numbers beyond those of every agent."""
        return {}

    def state(self) -> State:
        """The networks, how much noise was drawn, and environment steps."""
        first, second = self._networks.critics
        return {
            "explorations": np.array(self._explorations),
            "steps": np.array(self._steps),
            **within("actor", self.actor.state()),
            **within("critic 1", first.state()),
            **within("critic 2", second.state()),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        first, second = self._networks.critics
        self._explorations = int(state["explorations"])
        self._steps = int(state["steps"])
        self.actor.restore(part(state, "actor"))
        first.restore(part(state, "critic 1"))
        second.restore(part(state, "critic 2"))


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: TD3Config,
) -> OffPolicyLearner:
    """A cohort of TD3 runs; with weights other than 0, of its hybrid."""
    matching = matching_of(weights, ROBUST, config.placebo, config.match_every)
    return cohort(TD3, environment, seeds, matching, timesteps, config)
