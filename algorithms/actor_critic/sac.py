"""SAC: soft actor-critic as first published, and its hybrid.

    Q1, Q2   down   1/B sum (Q(s, a) - Qhat)^2,  Qhat = c r + gamma (1 - terminated) V'(s')
    V        down   1/B sum (V(s) - min Q(s, a~) + log pi(a~ | s))^2,            a~ ~ pi(. | s)
    pi       down   1/B sum log pi(a~ | s) - Q1(s, a~)
    target   V' += tau (V - V')

The temperature is fixed; the reward scale c is its inverse. The hybrid adds to both Qs the L2
gradient loss (algorithms.matching.losses) against

    dQhat = c (dr + dr/ds' J) + gamma (1 - terminated) dV'/ds' J

Runs are measured with the mean action, tanh mu.

Sources: Haarnoja et al. (2018), "Soft actor-critic: off-policy maximum entropy deep reinforcement
learning with a stochastic actor", and the authors' code, commit 8258e33, from which it takes Q1,
not the minimum, in the policy's loss; the hybrid, "D3PG" (2019), appendix A.2. Differences:

- the networks are those of every learner here (algorithms.networks.network): 64-64 tanh units with
  layer normalisation, small last layers; not 256-256 ReLU. Batches are of 64, not 256;
- features are normalised; V and both Q are in one unit, which follows the targets of Q
  (algorithms.networks.value_scale); log pi, in the unit of c r, is divided by it in the target of
  V;
- squared losses have no factor 1/2, so that w1 and w2 weigh as they do in DDPG;
- 100 steps, then 100 updates; not step by step. All networks are updated from one batch;
- no uniform actions at first: the initial policy is the tanh of about a standard normal;
- log(1 - tanh^2 u) is exact (algorithms.networks.gaussian);
- nothing regularises the policy. The authors' code has a regulariser, 1e-3 times the means of
  mu^2 / 2 and of (log sigma)^2 / 2; at that commit no loss takes it in;
- everything in float32 but the simulator and the statistics.
"""

from collections.abc import Sequence

import numpy as np

from algorithms.actor_critic.learner import OffPolicyLearner
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
from algorithms.early_end import NotFiniteQuantityError
from algorithms.experience.replay import Replay, check_finite, empty_memory
from algorithms.experience.rollout import Experience, Rollout
from algorithms.matching.diagnostics import UpdateMeans, agreement, with_derivatives
from algorithms.matching.losses import Matching, is_matched, matching_of
from algorithms.networks import network
from algorithms.networks.network import Shape
from algorithms.networks.optimizer import learned, learned_alone
from algorithms.networks.policy import Policy
from algorithms.networks.scaling import Coordinates, Statistics, coordinates_of
from algorithms.networks.value_scale import move_value_scale, rewrite_fit
from algorithms.settings import SACConfig
from algorithms.snapshot import Critic, Snapshot
from algorithms.state import State, part, within
from algorithms.stopwatch import Cost, Stopwatch
from physics.environment import Environment
from physics.randomness import generator

MEANS = (
    "critic_loss",
    "gradient_loss",
    "value_loss",
    "q_mean",
    "entropy",
    "critic_gradient_norm",
    "value_gradient_norm",
    "actor_gradient_norm",
)


class SACAgent:
    """One run of SAC, or of its hybrid; see `algorithms.actor_critic.learner.Agent`."""

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        matching: Matching,
        timesteps: int,
        config: SACConfig,
    ) -> None:
        """Draw the initial networks.

        Args:
            environment: the task.
            coordinates: of its features.
            seed: of the run.
            matching: of the critics' gradients.
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
            np.float32(config.reward_scale),
            config.rate,
        )
        self._shapes = shapes_of(environment, config)
        self._networks = initial_networks(self._shapes, seed)
        self._statistics = Statistics(coordinates, environment.action_size)
        self._explorations = 0
        capacity = min(config.replay_size, timesteps)
        memory = empty_memory(capacity, environment, coordinates, linearized=self._matched)
        self.replay = Replay(memory, environment.state_size)
        self._means = UpdateMeans(MEANS)

    def policy(self) -> Policy:
        """The mean of the policy learned so far."""
        return self._policy(steps=0, noise=generator(self.seed, "exploration"))

    def exploring_policy(self) -> Policy:
        """The policy, with new noise for a cycle."""
        noise = generator(self.seed, "exploration", self._explorations)
        self._explorations += 1
        return self._policy(self._config.rollout_steps, noise)

    def remember(self, experience: Experience) -> None:
        """Store the transitions and take in their features."""
        transitions, c = experience.transitions, self._config.reward_scale
        check_finite(transitions)
        self._statistics.observe(np.ascontiguousarray(transitions.features))
        self._statistics.observe_rewards(c * transitions.rewards.astype(np.float64))
        self.replay.extend(transitions, experience.states)
        self.jacobians += len(experience.states) if self._matched else 0

    def learn(self) -> None:
        """Update all networks, move the unit of V and Q."""
        count, batch = self._config.cycle_updates, self._config.batch_size
        draws = generator(self.seed, "batches", self.updates)
        indices = draws.integers(self.replay.size, size=(count, batch))
        noise = draws.standard_normal((count, batch, self._environment.action_size), np.float32)
        report = empty_report(count)
        done, lost = update(
            self._networks, self.updates, self.replay.memory, indices, noise,
            self._coordinates, self._statistics.scaling(), self._rates, self._matching,
            self._shapes, report,
        )  # fmt: skip
        self.updates += done
        if lost >= 0:
            raise NotFiniteQuantityError(QUANTITIES[lost])
        self._move_value_scale(report)
        self._means.add(report)

    def diagnose(self, timestep: int) -> dict[str, float]:
        """The means of the updates since the last call, and how well gradients fit.

        Numbers in the unit of Q are those of the rewards as the task gives them.
        """
        draws = generator(self.seed, "diagnostics", timestep)
        indices = draws.integers(self.replay.size, size=self._config.batch_size)
        drawn = with_derivatives(self._environment, self._coordinates, self.replay, indices)
        self.jacobians += len(indices)
        gradient, target = gradient_pair(
            self._networks, drawn, self._coordinates, self._statistics.scaling(),
            self._rates, self._shapes,
        )  # fmt: skip
        means, c = self._means.take(), self._config.reward_scale
        return {
            **means,
            "q_mean": means["q_mean"] / c,
            **agreement(gradient, target, self._coordinates),
            "value_std": self._statistics.value_std / c,
        }

    def state(self) -> State:
        """All that its next bits depend on but the replay."""
        own = {
            "updates": np.array(self.updates),
            "jacobians": np.array(self.jacobians),
            "explorations": np.array(self._explorations),
        }
        return (
            own
            | within("networks", self._networks.state())
            | within("statistics", self._statistics.state())
            | within("means", self._means.state())
        )

    def restore(self, state: State) -> None:
        """Take up what `state` gave."""
        self.updates = int(state["updates"])
        self.jacobians = int(state["jacobians"])
        self._explorations = int(state["explorations"])
        self._networks.restore(part(state, "networks"))
        self._statistics.restore(part(state, "statistics"))
        self._means.restore(part(state, "means"))

    def snapshot(self, timestep: int) -> Snapshot:
        """The mean of the policy, and the first critic, in the unit of the task's rewards."""
        statistics, c = self._statistics, self._config.reward_scale
        policy, m = self.policy(), self._environment.action_size
        return Snapshot(
            timestep,
            self._config.hidden_units,
            m,
            policy._replace(theta=network.first_outputs(policy.theta, self._shapes.policy, m)),
            Critic(
                self._networks.critics[0].theta,
                statistics.value_mean / c,
                statistics.value_std / c,
            ),
        )

    def _policy(self, steps: int, noise: np.random.Generator) -> Policy:
        """The policy with noise for so many steps."""
        scaling, m = self._statistics.scaling(), self._environment.action_size
        return Policy(
            self._networks.policy.theta,
            scaling.mean,
            scaling.inverse,
            noise.standard_normal((steps, m), np.float32),
        )

    def _move_value_scale(self, report: Report) -> None:
        """Set the unit of V and Q to the cycle's targets, leaving them as they are."""
        change = move_value_scale(
            self._statistics, report.target_mean.mean(), report.target_square.mean()
        )
        rewrite_fit(self._networks.value, self._shapes.value, change)
        for critic in self._networks.critics:
            rewrite_fit(critic, self._shapes.critic, change)


def shapes_of(environment: Environment, config: SACConfig) -> Shapes:
    """The sizes of the networks; the policy has a mean and a log sigma for each action."""
    features, m, hidden = environment.feature_size, environment.action_size, config.hidden_units
    return Shapes(
        Shape(features, hidden, 2 * m), Shape(features, hidden, 1), Shape(features + m, hidden, 1)
    )


def initial_networks(shapes: Shapes, seed: int) -> Networks:
    """The networks of a run about to begin."""
    first, second = (
        learned_alone(network.initial(shapes.critic, generator(seed, "critic", k)))
        for k in range(2)
    )
    return Networks(
        learned_alone(network.initial(shapes.policy, generator(seed, "actor"))),
        learned(network.initial(shapes.value, generator(seed, "value"))),
        (first, second),
    )


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: SACConfig,
) -> OffPolicyLearner:
    """A cohort of SAC runs; with weights other than 0, of its hybrid."""
    coordinates = coordinates_of(environment)
    matching = matching_of(weights, by_cosine=False)
    stopwatch = Stopwatch({seed: Cost() for seed in seeds})
    with stopwatch.aside():
        agents = [
            SACAgent(environment, coordinates, seed, matching, timesteps, config) for seed in seeds
        ]
        rollout = Rollout(
            environment, coordinates, seeds,
            linearized=is_matched(matching), time_limit_is_terminal=False,
        )  # fmt: skip
    return OffPolicyLearner(
        environment, agents, rollout, agents[0]._shapes.policy,
        stopwatch=stopwatch, timesteps=timesteps, rollout_steps=config.rollout_steps,
    )  # fmt: skip
