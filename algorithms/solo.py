"""Solo: runs that act and learn independently, the shortest way to write your own learner.

A `SoloRun` is one seed. Its author defines how it begins, explores and improves. Counting,
measuring, saving, restoring, snapshots, and errors that end one run alone are the same for all.

    for each update:   lived = explore()        takes episodes and counts their steps
                       (measurements that become due are of the policy here)
                       improve(lived)           changes theta
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.experience.evaluation import play
from algorithms.experience.rollout import start_states
from algorithms.failing_rows import found
from algorithms.networks.policy import Policies, Policy, deterministic
from algorithms.networks.shape import HiddenSettings, parameter_size, shape_of
from algorithms.on_policy.counted_run import CountedRun
from algorithms.on_policy.learner import OnPolicyLearner
from algorithms.snapshot import Snapshot, inside
from algorithms.state import State
from physics.environment import Environment
from physics.randomness import generator

Config = TypeVar("Config", bound=HiddenSettings)


class SoloRun(CountedRun, ABC, Generic[Config]):
    """One run; see `algorithms.on_policy.learner.Run`.

    Attributes:
        learned: names of the attributes on which the next bits depend, arrays and numbers. They are
            saved in checkpoints.
        theta: float32 [P], the parameters of the actor, a network of the shape `shape`.
        environment, seed, config: the arguments of the run.
        timestep: environment steps so far; `explore` counts them.
        jacobians: Jacobians so far; `explore` counts them, if it needs any.
        updates: calls of `improve` so far.
    """

    counters = (*CountedRun.counters, "_episodes")
    learned: ClassVar[Sequence[str]] = ("theta",)
    theta: NDArray[np.float32]

    def __init__(self, environment: Environment, seed: int, timesteps: int, config: Config) -> None:
        """Begin a run of `timesteps`."""
        super().__init__(seed, timesteps)
        self.environment, self.config = environment, config
        self.shape = shape_of(environment.feature_size, environment.action_size, config)
        self._episodes = self._counted = 0
        self.begin()

    @abstractmethod
    def begin(self) -> None:
        """Set theta, and every other attribute of `learned`."""

    @abstractmethod
    def explore(self) -> Any:
        """Act for some episodes, and return the data from which `improve` learns."""

    @abstractmethod
    def improve(self, lived: Any) -> None:
        """Change theta, given the result of `explore`."""

    def random(self, purpose: str, index: int = 0) -> np.random.Generator:
        """The generator of this seed, for a purpose in words and an index."""
        return generator(self.seed, purpose, index)

    def returns_of(self, thetas: NDArray[np.float32]) -> NDArray[np.float64]:
        """The returns [K] of actors [K, P]: an episode of each, from the same new start state.

        The episodes' steps are counted.
        """
        starts, unborn = start_states(
            self.environment, [(self.seed, "episode", self._episodes)] * len(thetas)
        )
        self._episodes += 1
        policies = Policies([self.policy_of(theta) for theta in thetas], self.shape)
        played, failures = play(self.environment, policies, starts)
        for error in (failures | unborn).values():
            raise error
        self.timestep += int(played.steps.sum())
        return played.returns

    def policy_of(self, theta: NDArray[np.float32]) -> Policy:
        """The policy of an actor, with unnormalised features.

        Raises:
            ValueError: for an array that is not a theta.
        """
        size = parameter_size(self.shape)
        if theta.dtype != np.float32 or theta.shape != (size,):
            raise ValueError(
                f"{type(self).__name__}: theta must be float32 [{size}], not "
                f"{theta.dtype} {list(theta.shape)}"
            )
        mean = np.zeros(self.shape.inputs, np.float32)
        return deterministic(theta, mean, np.ones_like(mean), self.environment.action_size)

    def policy(self) -> Policy:
        """The policy as it is."""
        return self.policy_of(self.theta)

    def count(self, lived: Any) -> None:
        """Check that the steps of `explore` were counted."""
        del lived
        if self.timestep <= self._counted:
            raise ValueError(
                f"{type(self).__name__}.explore counted no environment steps: it has to add them "
                "to self.timestep"
            )
        self._counted = self.timestep

    def learn(self, lived: Any) -> None:
        """Improve, and check that theta is finite."""
        self.improve(lived)
        self.updates += 1
        if not np.isfinite(self.theta).all():
            raise NotFiniteQuantityError("theta")

    @property
    def nbytes(self) -> int:
        """Negligible; a run that stores much data overrides this (see `Algorithm.memory`)."""
        return 0

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        super().restore(state)
        self._counted = self.timestep

    def snapshot(self) -> Snapshot:
        """The policy as it is."""
        m = self.environment.action_size
        return Snapshot(self.timestep, m, inside(self.shape), self.policy())


class SoloLearner(OnPolicyLearner[SoloRun[Any], Any]):
    """A cohort of such runs; see `algorithms.learner.Learner`."""

    def _live(self) -> Mapping[int, Callable[[], Any]]:
        return {run.seed: partial(found, attempted(run.explore)) for run in self._runs}


def attempted(call: Callable[[], Any]) -> Any:
    """The result of a call, or the error that it raises."""
    try:
        return call()
    except Exception as error:
        return error


def builder_of(
    run: Callable[[Environment, int, int, Any], SoloRun[Any]],
) -> Callable[..., SoloLearner]:
    """The builder of an `Algorithm` with runs of this class."""

    def build(
        environment: Environment,
        seeds: Sequence[int],
        weights: tuple[float, float],
        timesteps: int,
        config: Any,
    ) -> SoloLearner:
        del weights
        runs = [run(environment, seed, timesteps, config) for seed in seeds]
        return SoloLearner(environment, runs, runs[0].shape, timesteps)

    return build
