"""One run of an on-policy learner with a value function: networks, episodes and counters.

A `Rule` defines how the networks learn from a window. Values have a unit that follows their targets
(algorithms.networks.value_scale). The targets of a window are known before a network is fitted to
them, so the unit changes first, and the first losses are small.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.matching.diagnostics import UpdateMeans
from algorithms.memory import window_bytes
from algorithms.networks.optimizer import Learned, learned, learned_alone
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policy, deterministic
from algorithms.networks.scaling import Coordinates, Scaling, Statistics
from algorithms.networks.shape import HiddenSettings, Shape, shape_of
from algorithms.networks.value_scale import UnitChange, move_value_scale, rewrite_fit
from algorithms.on_policy import actor
from algorithms.on_policy.counted_run import CountedRun, Part
from algorithms.on_policy.window import Episodes, Window, check_finite
from algorithms.snapshot import Snapshot, inside
from physics.environment import Environment
from physics.randomness import generator


class Settings(HiddenSettings, Protocol):
    """The settings that every such learner has (algorithms.settings)."""

    @property
    def environments(self) -> int:
        """The number of environments that are stepped at once."""

    @property
    def window(self) -> int:
        """Steps of each environment between two updates."""

    @property
    def noise(self) -> float:
        """Initial standard deviation of exploration."""


class Networks(NamedTuple):
    """The networks of one run."""

    actor: Learned
    critic: Learned
    actor_shape: Shape
    critic_shape: Shape


class Moment(NamedTuple):
    """The moment of an update in its run."""

    done: int
    """Updates done before this one."""
    progress: float
    """Share of the run's timesteps before the window, below 1."""
    scaling: Scaling
    """Normalisation of features as the window was acted with, and the unit of its targets."""
    draws: np.random.Generator


class Outlook(NamedTuple):
    """The values of a window's states, in the task's units."""

    returns: NDArray[np.float64]
    """[T, E], the targets of values."""
    values: NDArray[np.float64]
    """[T, E], the values by the rule's networks so far."""
    beyond: NDArray[np.float64]
    """[T, E, n], gradients of values in the states that steps led to; [0, 0, n] if not needed."""


class Report(NamedTuple):
    """The report of an update; `lost` is the quantity that is no longer finite, "" for none."""

    means: Any
    """A tuple with a field for each of the rule's names."""
    lost: str = ""


def lost_of(quantities: Mapping[str, float]) -> str:
    """The first quantity that is not finite; "" for none."""
    return next((name for name, value in quantities.items() if not np.isfinite(value)), "")


class Rule(Protocol):
    """How networks learn from a window.

    Attributes:
        linearized: whether it needs the derivatives of steps.
        means: names of its reports, which are means over the updates between two measurements.
    """

    linearized: bool
    means: Sequence[str]

    def look_ahead(self, networks: Networks, window: Window, scaling: Scaling) -> Outlook:
        """Compute the values of the window's states; no network changes."""

    def learn(self, networks: Networks, window: Window, outlook: Outlook, moment: Moment) -> Report:
        """Learn from a window."""

    def change_unit(self, networks: Networks, change: UnitChange) -> None:
        """Adapt Adam's moments of the actor to the new unit of values."""


class WindowRun(CountedRun):
    """One run; its steps are those of all its environments, and each update uses one window.

    Attributes:
        episodes: the ongoing episodes.
    """

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        timesteps: int,
        config: Settings,
        rule: Rule,
    ) -> None:
        """Draw the initial networks."""
        super().__init__(seed, timesteps)
        features, m = environment.feature_size, environment.action_size
        actor_shape = shape_of(features, m, config)
        critic_shape = shape_of(features, 1, config)
        theta = actor.initial(actor_shape, generator(seed, "actor"), config.noise)
        self.networks = Networks(
            learned_alone(theta),
            learned(initial_theta(critic_shape, generator(seed, "critic"))),
            actor_shape,
            critic_shape,
        )
        self.episodes = Episodes(seed, config.environments, environment.state_size)
        self._environment = environment
        self._config = config
        self._rule = rule
        self._statistics = Statistics(coordinates, m)
        self._means = UpdateMeans(rule.means)

    @property
    def nbytes(self) -> int:
        """Memory of one window."""
        return window_bytes(self._environment, self._config, linearized=self._rule.linearized)

    def policy(self) -> Policy:
        """The current deterministic policy."""
        scaling, m = self._statistics.scaling(), self._environment.action_size
        return deterministic(self.networks.actor.theta, scaling.mean, scaling.inverse, m)

    def noise_ahead(self) -> NDArray[np.float32]:
        """The noise that the coming window adds to the actor's means [T, E, m]."""
        m = self._environment.action_size
        draws = generator(self.history.seed, "exploration", self.updates)
        size = self._config.window, self._config.environments, m
        sigma = actor.spread_of(self.networks.actor.theta, m)
        return sigma * draws.standard_normal(size, np.float32)

    def count(self, window: Window) -> None:
        """Count the steps of the coming update's window."""
        self.timestep += window.rewards.size
        self.jacobians = self.timestep if self._rule.linearized else 0

    def learn(self, window: Window) -> None:
        """Set the unit of values to the window's targets, then update the networks."""
        check_finite(window)
        self._statistics.observe_rewards(window.rewards.ravel())
        before = (self.timestep - window.rewards.size) / self._timesteps
        draws = generator(self.history.seed, "batches", self.updates)
        outlook = self._rule.look_ahead(self.networks, window, self._statistics.scaling())
        self._move_unit(outlook.returns)
        moment = Moment(self.updates, before, self._statistics.scaling(), draws)
        report = self._rule.learn(self.networks, window, outlook, moment)
        if report.lost:
            raise NotFiniteQuantityError(report.lost)
        self.updates += 1
        seen = window.features.reshape(-1, window.features.shape[2])
        self._statistics.observe(seen.astype(np.float32))
        self._means.add(report.means)

    def _move_unit(self, returns: NDArray[np.float64]) -> None:
        if not np.isfinite(returns).all():
            raise NotFiniteQuantityError("critic target")
        targets = (returns - self._statistics.value_mean) / self._statistics.value_std
        moments = float(targets.mean()), float(np.square(targets).mean())
        change = move_value_scale(self._statistics, *moments)
        rewrite_fit(self.networks.critic, self.networks.critic_shape, change)
        self._rule.change_unit(self.networks, change)

    def diagnostics(self) -> dict[str, float]:
        """The rule's means since the last measurement, the noise, and the unit of values."""
        m = self._environment.action_size
        spread = actor.spread_of(self.networks.actor.theta, m)
        return {
            **self._means.take(),
            "noise": float(spread.mean()),
            "value_std": self._statistics.value_std,
        }

    def parts(self) -> dict[str, Part]:
        """The networks, the episodes, the statistics of features and the means of updates."""
        return {
            "actor": self.networks.actor,
            "critic": self.networks.critic,
            "episodes": self.episodes,
            "statistics": self._statistics,
            "means": self._means,
        }

    def snapshot(self) -> Snapshot:
        """The current mean policy; without a critic, since V is not a Q."""
        m, policy = self._environment.action_size, self.policy()
        alone = policy._replace(theta=policy.theta[:-m])
        return Snapshot(self.timestep, m, inside(self.networks.actor_shape), alone)
