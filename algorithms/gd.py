"""GD: gradient ascent on the return itself, through the simulator, for a cohort of runs.

    theta  up   1/E sum over episodes of dR/dtheta          (algorithms.episode_gradient)

Each update lives E whole episodes under the deterministic actor, from new start states, and takes
one step of Adam along the exact gradient of their mean undiscounted return; its norm is clipped,
since over a hundred steps of a chaotic system it may be anything. A gradient or an actor that is
not finite ends the run.

The actor is the one that the other learners of that seed begin with. Its features are normalised as
theirs are, by the mean and standard deviation of all the run has seen; these move between updates.

A run ends at its timesteps, or when its curve has reached a plateau: when the mean of its latest
ten `return_mean` has had no new best for `patience` measurements.

Sources: Hu et al. (2019) and Degrave et al. (2019), as the paper's section 5.2 sums them up; Adam,
Kingma and Ba (2014). The backward pass through an episode is written out and compiled instead of
left to autograd through `physics.torch_step`: the same derivatives, and the tests hold one against
the other. What the paper leaves open: the step size, the number of episodes, the clipping.
"""

import time
from collections.abc import Collection, Sequence

import numpy as np

from algorithms import network
from algorithms.episode_gradient import LinearizedEpisodes, live, return_gradient
from algorithms.evaluation import episode_returns
from algorithms.gd_config import GDConfig
from algorithms.history import History
from algorithms.layer import Array
from algorithms.measurement import Divergence, Measurement
from algorithms.network import Shape
from algorithms.optimizer import Learned, adam, corrected, learned
from algorithms.policy import Policies, Policy
from algorithms.rollout import start_states
from algorithms.scaling import Coordinates, Statistics, coordinates_of
from algorithms.threads import one_thread
from physics.compiled import compiled_fast
from physics.environment import Environment
from physics.randomness import generator

SMOOTHED = 10
"""Measurements whose mean tells whether a curve still rises."""


class GDRun:
    """One actor and how far it has come.

    Attributes:
        history: its measurements.
        timestep: steps of its episodes so far, each with its Jacobian.
        updates: steps of Adam so far.
    """

    def __init__(
        self, environment: Environment, coordinates: Coordinates, seed: int, config: GDConfig
    ) -> None:
        """Draw the initial actor."""
        self.history = History(seed)
        self.timestep = 0
        self.updates = 0
        self._config = config
        self._environment = environment
        self._shape = shape_of(environment, config)
        self._actor = learned(network.initial(self._shape, generator(seed, "actor")))
        self._statistics = Statistics(coordinates, environment.action_size)
        self._gradient_norms: list[float] = []
        self._best = -np.inf
        self._best_at = 0

    def policy(self) -> Policy:
        """The actor as it is."""
        scaling = self._statistics.scaling()
        return Policy(self._actor.theta, scaling.mean, scaling.inverse)

    def episodes_ahead(self) -> list[tuple[int, str, int]]:
        """Where the next update's episodes start, for `start_states`."""
        each = self._config.episodes
        first = self.updates * each
        return [(self.history.seed, "episode", i) for i in range(first, first + each)]

    def learn(self, episodes: LinearizedEpisodes) -> str | None:
        """Update by what the actor lived; return the name of a quantity that is not finite."""
        theta, mean, inverse = self.policy()
        gradient = np.empty_like(theta)
        return_gradient(
            theta, self._shape, mean, inverse, self._environment.feature_sources, episodes, gradient
        )
        norm, is_finite = climb(
            self._actor, gradient, self._config.rate, self.updates + 1, self._config.clip
        )
        if not np.isfinite(norm):
            return "gradient"
        if not is_finite:
            return "parameters"
        self.updates += 1
        self._gradient_norms.append(norm)
        for e, end in enumerate(episodes.ends):
            self._statistics.observe(episodes.features[:end, e].astype(np.float32))
        return None

    def measured(self, return_mean: float) -> Measurement:
        """Take in a measurement."""
        norms, self._gradient_norms = self._gradient_norms, []
        self.history.record(return_mean)
        measurement = self.history.measured(
            updates=self.updates,
            jacobians=self.timestep,
            diagnostics={"gradient_norm": float(np.median(norms)) if norms else np.nan},
        )
        latest = float(np.mean([*self.history.returns][-SMOOTHED:]))
        if latest > self._best:
            self._best, self._best_at = latest, self.history.count
        return measurement

    @property
    def is_on_plateau(self) -> bool:
        """Whether its curve has not risen for long."""
        return self.history.count - self._best_at >= self._config.patience


class GDLearner:
    """A cohort of runs on one task; see `algorithms.learner.Learner`.

    Attributes:
        timestep: environment steps, the fewest of any run: episodes that end early cost less.
    """

    def __init__(
        self, environment: Environment, seeds: Sequence[int], timesteps: int, config: GDConfig
    ) -> None:
        """Draw the initial actors."""
        self._environment = environment
        self._timesteps = timesteps
        self._shape = shape_of(environment, config)
        coordinates = coordinates_of(environment)
        self._runs = [GDRun(environment, coordinates, seed, config) for seed in seeds]
        self.timestep = 0

    @property
    def seeds(self) -> list[int]:
        """The seeds still in training."""
        return [run.history.seed for run in self._runs]

    @property
    def finished(self) -> bool:
        """Whether nothing is left to do."""
        return not self._runs

    def advance(self) -> list[Measurement | Divergence]:
        """Do one update of every run."""
        start, runs = time.perf_counter(), self._runs
        with one_thread():
            episodes = self._live()
            for k, run in enumerate(runs):
                run.timestep += int(episodes.ends[k].sum())
            measured = self._measure()
            diverged = self._learn(episodes)
        share = (time.perf_counter() - start) / len(runs)
        for run in runs:
            run.history.seconds += share
        self.timestep = min(self._timesteps, *(run.timestep for run in runs))
        self._runs = [
            run for run in self._runs if run.timestep < self._timesteps and not run.is_on_plateau
        ]
        return [*measured, *diverged]

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds."""
        self._runs = [run for run in self._runs if run.history.seed not in seeds]

    def _live(self) -> LinearizedEpisodes:
        """The episodes of the coming update."""
        starts = np.stack(
            [start_states(self._environment, run.episodes_ahead()) for run in self._runs]
        )
        return live(self._environment, [r.policy() for r in self._runs], self._shape, starts)

    def _measure(self) -> list[Measurement]:
        """The measurements that came due during the episodes, of the actors that lived them."""
        due = [
            (run, number)
            for run in self._runs
            for number in run.history.due(min(run.timestep, self._timesteps))
        ]
        if not due:
            return []
        policies = Policies([run.policy() for run, _ in due], self._shape)
        starts = start_states(
            self._environment, [(run.history.seed, "evaluation", number) for run, number in due]
        )
        returns = episode_returns(self._environment, policies, starts)
        return [run.measured(float(value)) for (run, _), value in zip(due, returns, strict=True)]

    def _learn(self, episodes: LinearizedEpisodes) -> list[Divergence]:
        """Update every actor; those that diverge leave."""
        divergences = []
        for k, run in enumerate(self._runs):
            quantity = run.learn(episodes.of(k))
            if quantity is not None:
                divergences.append(
                    Divergence(run.history.seed, run.timestep, run.updates + 1, quantity)
                )
        self.drop({divergence.seed for divergence in divergences})
        return divergences


@compiled_fast
def climb(
    actor: Learned, gradient: Array, rate: float, update: int, clip: float
) -> tuple[float, bool]:
    """Step the actor up a gradient; return the gradient's norm and whether the actor is finite."""
    square = 0.0
    for i in range(gradient.size):
        square += np.float64(gradient[i]) * np.float64(gradient[i])
    norm = np.sqrt(square)
    if not np.isfinite(norm):
        return norm, True
    scale = -min(1.0, clip / norm) if norm > 0.0 else -1.0
    for i in range(gradient.size):
        gradient[i] *= scale
    _, theta_norm = adam(actor, gradient, corrected(rate, update))
    return norm, bool(np.isfinite(theta_norm))


def shape_of(environment: Environment, config: GDConfig) -> Shape:
    """The sizes of the actor."""
    return Shape(environment.feature_size, config.hidden_units, environment.action_size)


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: GDConfig,
) -> GDLearner:
    """A cohort of GD runs, which have no use for weights."""
    del weights
    return GDLearner(environment, seeds, timesteps, config)
