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
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from algorithms.episode_gradient import LinearizedEpisodes, live
from algorithms.evaluation import episode_returns
from algorithms.gd_config import GDConfig
from algorithms.gd_run import GDRun, shape_of
from algorithms.measurement import Divergence, Measurement
from algorithms.policy import Policies
from algorithms.rollout import start_states
from algorithms.scaling import coordinates_of
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State
from algorithms.threads import one_thread
from physics.environment import Environment


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
        self._by_seed = dict(zip(seeds, self._runs, strict=True))  # those that ended stay here
        self.timestep = 0

    @property
    def seeds(self) -> list[int]:
        """The seeds still in training."""
        return [run.history.seed for run in self._runs]

    @property
    def bytes_per_run(self) -> int:
        """Memory of one update's episodes."""
        return max((run.nbytes for run in self._runs), default=0)

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
        if self._runs:
            self._count()
        self._runs = [
            run for run in self._runs if run.timestep < self._timesteps and not run.is_on_plateau
        ]
        return [*measured, *diverged]

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds."""
        self._runs = [run for run in self._runs if run.history.seed not in seeds]

    def state(self, seed: int) -> State:
        """All that the run's next bits depend on."""
        return self._by_seed[seed].state()

    def journal(self, seed: int, start: int) -> State:
        """Nothing: no update looks back beyond its own episodes."""
        del seed, start
        return {}

    def restore(self, saved: Mapping[int, Saved]) -> None:
        """Take up every run where it was left."""
        for run in self._runs:
            run.restore(saved[run.history.seed].state)
        self._count()

    def snapshot(self, seed: int) -> Snapshot:
        """What the run has learned so far, or by its end."""
        return self._by_seed[seed].snapshot()

    def _count(self) -> None:
        self.timestep = min(self._timesteps, *(run.timestep for run in self._runs))

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
