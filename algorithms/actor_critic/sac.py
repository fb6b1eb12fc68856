"""SAC: soft actor-critic as first published, and its hybrid.

    Q1, Q2   down   1/B sum (Q(s, a) - Qhat)^2,  Qhat = c r + gamma (1 - terminated) V'(s')
    V        down   1/B sum (V(s) - min Q(s, a~) + log pi(a~ | s))^2,            a~ ~ pi(. | s)
    pi       down   1/B sum log pi(a~ | s) - Q1(s, a~)
    target   V' += tau (V - V')

The temperature is fixed, and the reward scale c is its inverse; or it is learned
(`temperature="learned"`): log pi is multiplied by alpha, which drives the entropy to -m, for m
actions, and c is 1 (Haarnoja et al., 2019). Alpha starts at the size of the first rewards. The
hybrid adds to the losses of both Qs the L2 gradient loss (algorithms.matching.losses) against

    dQhat = c (dr + dr/ds' J) + gamma (1 - terminated) dV'/ds' J

Runs are measured with the mean action, tanh mu.

Sources: Haarnoja et al. (2018), "Soft actor-critic: off-policy maximum entropy deep reinforcement
learning with a stochastic actor", and the authors' code, commit 8258e33, whose policy loss has Q1
instead of the minimum; for the hybrid, "D3PG" (2019), appendix A.2. Differences:

- the networks are those of every learner here (algorithms.networks.network): 64-64 tanh units with
  layer normalisation, small last layers; not 256-256 ReLU. Batches are of 64, not 256;
- features are normalised; V and both Q are in one unit, which follows the targets of Q
  (algorithms.networks.value_scale); log pi, in the unit of c r, is divided by that unit in the
  target of V;
- squared losses have no factor 1/2, so that w1 and w2 have the same weight as in DDPG;
- a cycle is 100 steps, then 100 updates; they do not alternate step by step. All networks are
  updated from one batch;
- updates begin with the first cycle; in the authors' code, after the first 1,000 steps, whose
  actions are uniform in both;
- log(1 - tanh^2 u) is exact (algorithms.networks.gaussian);
- V is kept with a learned temperature; the authors' later code has target critics in its place;
- the policy is not regularised. The authors' code has a regulariser, 1e-3 times the means of
  mu^2 / 2 and of (log sigma)^2 / 2; at that commit no loss includes it;
- everything is in float32 except the simulator and the statistics.
"""

from collections.abc import Sequence

import numpy as np

from algorithms.actor_critic.agent import Cycle
from algorithms.actor_critic.learner import OffPolicyLearner, cohort
from algorithms.actor_critic.sac_update import (
    QUANTITIES,
    Networks,
    Rates,
    Report,
    Shapes,
    empty_report,
    gradient_pair,
    update,
)
from algorithms.experience.replay import Memory
from algorithms.matching.losses import L2, Matching, matching_of
from algorithms.networks.layer import Array
from algorithms.networks.optimizer import learned, learned_alone
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policy, uniform
from algorithms.networks.scaling import Coordinates, Scaling
from algorithms.networks.shape import shape_of
from algorithms.networks.value_scale import UnitChange, rescale_moments, rewrite_fit
from algorithms.settings import SACConfig
from algorithms.state import State, part, within
from physics.environment import Environment
from physics.randomness import generator


class SAC:
    """The networks of SAC and of its hybrid; see `algorithms.actor_critic.agent.ActorCritic`."""

    means: Sequence[str] = (
        "critic_loss",
        "gradient_loss",
        "value_loss",
        "q_mean",
        "entropy",
        "temperature",
        "critic_gradient_norm",
        "value_gradient_norm",
        "actor_gradient_norm",
    )
    quantities: Sequence[str] = QUANTITIES

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        matching: Matching,
        config: SACConfig,
    ) -> None:
        """Draw the initial networks."""
        learns_temperature = config.temperature == "learned"
        self.reward_scale = 1.0 if learns_temperature else config.reward_scale
        self._shapes = shapes_of(environment, config)
        self._networks = initial_networks(self._shapes, seed)
        self.actor_shape, self.actor = self._shapes.policy, self._networks.policy
        self.critic = self._networks.critics[0]
        self._seed = seed
        self._coordinates = coordinates
        self._matching = matching
        self._rates = Rates(
            np.float32(config.gamma),
            np.float32(config.tau),
            np.float32(self.reward_scale),
            config.rate,
            learns_temperature,
            np.float32(-environment.action_size),
        )
        self._noise_shape = config.rollout_steps, environment.action_size
        self._explorations = 0
        self._uniform_steps = config.uniform_steps
        self._steps = 0

    def explorer(self, policy: Policy) -> Policy:
        """Uniform actions at first, then the policy with noise, drawn for a cycle."""
        draws = generator(self._seed, "exploration", self._explorations)
        self._explorations += 1
        if self._steps < self._uniform_steps:
            return uniform(policy, self.actor_shape, self._noise_shape, draws)
        return policy._replace(noise=draws.standard_normal(self._noise_shape, np.float32))

    def update(self, cycle: Cycle) -> tuple[int, int, Report]:
        """Update all networks, with newly drawn actions."""
        self._steps = cycle.replay.count
        actions = self._noise_shape[1]
        noise = cycle.draws.standard_normal((*cycle.indices.shape, actions), np.float32)
        report = empty_report(len(cycle.indices))
        done, lost = update(
            self._networks, cycle.done, cycle.replay.memory, cycle.indices, noise,
            self._coordinates, cycle.scaling, self._rates, self._matching, self._shapes, report,
        )  # fmt: skip
        return done, lost, report

    def change_unit(self, change: UnitChange) -> None:
        """Leave V, both Q and the temperature as they are."""
        rewrite_fit(self._networks.value, self._shapes.value, change)
        for critic in self._networks.critics:
            rewrite_fit(critic, self._shapes.critic, change)
        if self._rates.learns_temperature:
            self._networks.temperature.theta[:] += np.float32(np.log(change.ratio))
            rescale_moments(self._networks.policy, np.float32(change.ratio))

    def gradient_pair(self, memory: Memory, scaling: Scaling) -> tuple[Array, Array]:
        """The first critic's gradient [B, C + m] and its target."""
        return gradient_pair(
            self._networks, memory, self._coordinates, scaling, self._rates, self._shapes
        )

    def diagnostics(self) -> dict[str, float]:
        """No numbers beyond those of every agent."""
        return {}

    def state(self) -> State:
        """The networks, how much noise was drawn, and environment steps."""
        return {
            "explorations": np.array(self._explorations),
            "steps": np.array(self._steps),
            **within("networks", self._networks.state()),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        self._explorations = int(state["explorations"])
        self._steps = int(state["steps"])
        self._networks.restore(part(state, "networks"))


def shapes_of(environment: Environment, config: SACConfig) -> Shapes:
    """The sizes of the networks; the policy has a mean and a log sigma for each action."""
    features, m = environment.feature_size, environment.action_size
    return Shapes(
        shape_of(features, 2 * m, config),
        shape_of(features, 1, config),
        shape_of(features + m, 1, config),
    )


def initial_networks(shapes: Shapes, seed: int) -> Networks:
    """The initial networks of a run."""
    first, second = (
        learned_alone(initial_theta(shapes.critic, generator(seed, "critic", k))) for k in range(2)
    )
    return Networks(
        learned_alone(initial_theta(shapes.policy, generator(seed, "actor"))),
        learned(initial_theta(shapes.value, generator(seed, "value"))),
        (first, second),
        learned_alone(np.zeros(1, np.float32)),
    )


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: SACConfig,
) -> OffPolicyLearner:
    """A cohort of SAC runs; with weights other than 0, of its hybrid."""
    matching = matching_of(weights, L2, config.placebo, config.match_every)
    return cohort(SAC, environment, seeds, matching, timesteps, config)
