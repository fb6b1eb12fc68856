"""Agent: one off-policy run: a replay, statistics of features and rewards, and an actor-critic.

An actor-critic has three parts of which an agent is independent: its networks, their update and
their exploration. Rewards, Q and its unit are in the actor-critic's own scale, c times the task's;
an agent's reports are in the task's scale.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.experience.replay import Memory, Replay, check_finite, empty_memory
from algorithms.experience.rollout import Experience
from algorithms.matching.diagnostics import (
    NO_AGREEMENT,
    UpdateMeans,
    agreement,
    with_derivatives,
)
from algorithms.networks.layer import Array
from algorithms.networks.optimizer import Learned
from algorithms.networks.parameters import first_outputs
from algorithms.networks.policy import Policy, deterministic
from algorithms.networks.scaling import Coordinates, Scaling, Statistics
from algorithms.networks.shape import HiddenSettings, Shape
from algorithms.networks.value_scale import UnitChange, move_value_scale
from algorithms.snapshot import Critic, Snapshot, inside
from algorithms.state import State, part, within
from physics.environment import Environment
from physics.randomness import generator


class Settings(HiddenSettings, Protocol):
    """The settings that every off-policy learner has (algorithms.settings)."""

    @property
    def batch_size(self) -> int:
        """Transitions per update."""

    @property
    def rollout_steps(self) -> int:
        """Environment steps per cycle."""

    @property
    def cycle_updates(self) -> int:
        """Updates per cycle."""

    @property
    def replay_size(self) -> int:
        """Transitions that the replay holds."""


class Cycle(NamedTuple):
    """The arguments of a cycle of updates."""

    done: int
    """Updates done before the cycle."""
    replay: Replay
    indices: NDArray[np.int64]
    """[U, B], the transitions of each update's batch."""
    draws: np.random.Generator
    """A generator for further random numbers."""
    scaling: Scaling


class ActorCritic(Protocol):
    """The networks of one run, how they are updated and how they explore.

    Attributes:
        means: fields of an update's report, arrays [U], that are reported as means.
        quantities: the quantities that an update checks for divergence.
        reward_scale: c, the factor of the task's rewards.
        actor, critic: the networks; the first of several critics.
        actor_shape: the actor's sizes.
    """

    means: Sequence[str]
    quantities: Sequence[str]
    reward_scale: float
    actor: Learned
    critic: Learned
    actor_shape: Shape

    def explorer(self, policy: Policy) -> Policy:
        """A policy that explores around the deterministic one, drawn again at each call."""

    def update(self, cycle: Cycle) -> tuple[int, int, Any]:
        """Update all networks on each of the batches.

        Returns:
            How many updates were done; -1, or the index in `quantities` of the one that is not
            finite; and the report, which also has the targets' `target_mean` and `target_square`,
            arrays [U].
        """

    def change_unit(self, change: UnitChange) -> None:
        """Change the unit of Q without changing Q."""

    def gradient_pair(self, memory: Memory, scaling: Scaling) -> tuple[Array, Array]:
        """The critic's gradient [B, C + m] and its target, at every transition of a memory."""

    def diagnostics(self) -> dict[str, float]:
        """Further numbers by name."""

    def state(self) -> State:
        """All values on which its next bits depend."""

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""


class Agent:
    """One run's learner.

    Its calls raise NotFiniteQuantityError where a quantity stops being finite.

    Attributes:
        seed: the run's seed.
        updates: updates done so far.
        jacobians: Jacobians of transitions computed so far.
        replay: the run's transitions.
    """

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        actor_critic: ActorCritic,
        timesteps: int,
        config: Settings,
        *,
        linearized: bool,
    ) -> None:
        """Begin with an empty replay.

        Args:
            environment: the task.
            coordinates: the coordinates of its features.
            seed: the run's seed.
            actor_critic: its networks, untrained.
            timesteps: those of the whole run, which bound its replay.
            config: the settings.
            linearized: whether transitions come with their derivatives.
        """
        self.seed = seed
        self.updates = 0
        self.jacobians = 0
        self._environment = environment
        self._coordinates = coordinates
        self._config = config
        self._linearized = linearized
        self._actor_critic = actor_critic
        self._statistics = Statistics(coordinates, environment.action_size)
        capacity = min(config.replay_size, timesteps)
        memory = empty_memory(capacity, environment, coordinates, linearized=linearized)
        self.replay = Replay(memory, environment.state_size)
        self._means = UpdateMeans(actor_critic.means)

    @property
    def actor_shape(self) -> Shape:
        """The sizes of the network that its policies are made of."""
        return self._actor_critic.actor_shape

    def policy(self) -> Policy:
        """The deterministic policy learned so far."""
        scaling, theta = self._statistics.scaling(), self._actor_critic.actor.theta
        return deterministic(theta, scaling.mean, scaling.inverse, self._environment.action_size)

    def exploring_policy(self) -> Policy:
        """A policy to explore with, drawn again at each call."""
        return self._actor_critic.explorer(self.policy())

    def remember(self, experience: Experience) -> None:
        """Store the transitions and add their features and rewards to the statistics."""
        transitions, c = experience.transitions, self._actor_critic.reward_scale
        check_finite(transitions)
        self._statistics.observe(np.ascontiguousarray(transitions.features))
        self._statistics.observe_rewards(c * transitions.rewards.astype(np.float64))
        self.replay.extend(transitions, experience.states)
        self.jacobians += len(experience.states) if self._linearized else 0

    def learn(self) -> None:
        """Do a cycle's updates, then set the unit of Q to its targets."""
        size = self._config.cycle_updates, self._config.batch_size
        draws = generator(self.seed, "batches", self.updates)
        indices = draws.integers(self.replay.size, size=size)
        scaling = self._statistics.scaling()
        done, lost, report = self._actor_critic.update(
            Cycle(self.updates, self.replay, indices, draws, scaling)
        )
        self.updates += done
        if lost >= 0:
            raise NotFiniteQuantityError(self._actor_critic.quantities[lost])
        moments = report.target_mean.mean(), report.target_square.mean()
        self._actor_critic.change_unit(move_value_scale(self._statistics, *moments))
        self._means.add(report)

    def diagnose(self, timestep: int) -> dict[str, float]:
        """The means of the updates since the last call, and how well gradients fit."""
        draws = generator(self.seed, "diagnostics", timestep)
        indices = draws.integers(self.replay.size, size=self._config.batch_size)
        means, c = self._means.take(), self._actor_critic.reward_scale
        return {
            **means,
            "q_mean": means["q_mean"] / c,
            **self._agreement(indices),
            **self._actor_critic.diagnostics(),
            "value_std": self._statistics.value_std / c,
        }

    def _agreement(self, indices: NDArray[np.int64]) -> dict[str, float]:
        """How well the critic's gradient fits its target, at these transitions of the replay.

        NaN if a step has no derivatives: learners that match no gradients do not need them.
        """
        try:
            drawn = with_derivatives(self._environment, self._coordinates, self.replay, indices)
        except (ValueError, ArithmeticError):
            return NO_AGREEMENT
        self.jacobians += len(indices)
        gradient, target = self._actor_critic.gradient_pair(drawn, self._statistics.scaling())
        return agreement(gradient, target, self._coordinates)

    def state(self) -> State:
        """All values on which its next bits depend, except the replay."""
        return {
            "updates": np.array(self.updates),
            "jacobians": np.array(self.jacobians),
            **self._actor_critic.state(),
            **within("statistics", self._statistics.state()),
            **within("means", self._means.state()),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned; the caller fills the replay."""
        self.updates = int(state["updates"])
        self.jacobians = int(state["jacobians"])
        self._actor_critic.restore(state)
        self._statistics.restore(part(state, "statistics"))
        self._means.restore(part(state, "means"))

    def snapshot(self, timestep: int) -> Snapshot:
        """The deterministic policy and the critic, in the unit of the task's rewards."""
        statistics, c = self._statistics, self._actor_critic.reward_scale
        policy, m = self.policy(), self._environment.action_size
        return Snapshot(
            timestep,
            m,
            inside(self.actor_shape),
            policy._replace(theta=first_outputs(policy.theta, self.actor_shape, m)),
            Critic(
                self._actor_critic.critic.theta, statistics.value_mean / c, statistics.value_std / c
            ),
        )
