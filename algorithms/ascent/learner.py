"""GD: gradient ascent on the return itself, through the simulator, for a cohort of runs.

    theta  up   1/E sum over episodes of dR/dtheta          (algorithms.ascent.episode_gradient)

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

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial

from algorithms.ascent.episode_gradient import LinearizedEpisodes, live
from algorithms.ascent.run import GDRun
from algorithms.early_end import EarlyEnd
from algorithms.experience.evaluation import episode_returns
from algorithms.experience.rollout import start_states
from algorithms.failing_rows import call_each, early_end, found
from algorithms.measurement import Measurement
from algorithms.networks import network
from algorithms.networks.policy import Policies
from algorithms.networks.scaling import coordinates_of
from algorithms.settings import GDConfig
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State
from algorithms.stopwatch import Stopwatch
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
        self._shape = network.shape_of(environment.feature_size, environment.action_size, config)
        coordinates = coordinates_of(environment)
        self._runs = [GDRun(environment, coordinates, seed, timesteps, config) for seed in seeds]
        self._by_seed = dict(zip(seeds, self._runs, strict=True))  # those that ended stay here
        self._stopwatch = Stopwatch({run.history.seed: run.history.cost for run in self._runs})
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

    def advance(self) -> list[Measurement | EarlyEnd]:
        """Do one update of every run."""
        with one_thread():
            with self._stopwatch.training(self.seeds):
                lived = self._live()
            ends = self._each(lambda run: run.count(lived[run.history.seed]()))
            measured = self._measure(ends)
            ends += self._learn(lived)
        if self._runs:
            self._count()
        self._runs = [
            run for run in self._runs if run.timestep < self._timesteps and not run.is_on_plateau
        ]
        self._stopwatch.keep(self.seeds)
        return [*measured, *ends]

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds."""
        self._runs = [run for run in self._runs if run.history.seed not in seeds]
        self._stopwatch.keep(self.seeds)

    def state(self, seed: int) -> State:
        """All that the run's next bits depend on."""
        return self._by_seed[seed].state()

    def journal(self, seed: int, start: int) -> State:
        """Nothing: no update looks back beyond its own episodes."""
        del seed, start
        return {}

    def restore(self, saved: Mapping[int, Saved]) -> None:
        """Restore every run as it was saved."""
        for run in self._runs:
            run.restore(saved[run.history.seed].state)
        self._count()

    def snapshot(self, seed: int) -> Snapshot:
        """What the run has learned so far, or by its end."""
        return self._by_seed[seed].snapshot()

    def _count(self) -> None:
        self.timestep = min(self._timesteps, *(run.timestep for run in self._runs))

    def _each(self, call: Callable[[GDRun], None]) -> list[EarlyEnd]:
        """Call for every run; those for which it raises leave."""
        ends = call_each(
            call,
            self._runs,
            lambda run, error: early_end(run.history.seed, run.timestep, run.updates + 1, error),
        )
        self.drop({end.seed for end in ends})
        return ends

    def _live(self) -> dict[int, Callable[[], LinearizedEpisodes]]:
        """What gives the episodes of each seed's coming update, or raises what they failed by."""
        purposes = [run.episodes_ahead() for run in self._runs]
        starts, unborn = start_states(self._environment, [each for run in purposes for each in run])
        shape = (len(purposes), -1, self._environment.state_size)
        episodes, failures = live(
            self._environment, [r.policy() for r in self._runs], self._shape, starts.reshape(shape)
        )
        each = len(starts) // len(purposes)
        errors = {row // each: error for row, error in (failures | unborn).items()}

        def episodes_of(k: int) -> LinearizedEpisodes:
            return found(errors[k] if episodes is None or k in errors else episodes.of(k))

        return {seed: partial(episodes_of, k) for k, seed in enumerate(self.seeds)}

    def _learn(self, lived: Mapping[int, Callable[[], LinearizedEpisodes]]) -> list[EarlyEnd]:
        """Let every run learn from its episodes."""

        def learn(run: GDRun) -> None:
            with self._stopwatch.training([run.history.seed]):
                run.learn(lived[run.history.seed]())

        return self._each(learn)

    def _measure(self, ends: list[EarlyEnd]) -> list[Measurement]:
        """The measurements that came due during the episodes, of the actors that acted in them.

        Runs for which that raises leave, and their ends are added to `ends`.
        """
        due = [
            (run, number)
            for run in self._runs
            for number in run.history.due(min(run.timestep, self._timesteps))
        ]
        if not due:
            return []
        purposes = [(run.history.seed, "evaluation", number) for run, number in due]
        with self._stopwatch.aside():
            policies = Policies([run.policy() for run, _ in due], self._shape)
            starts, unborn = start_states(self._environment, purposes)
            returns, failures = episode_returns(self._environment, policies, starts)
        errors = failures | unborn
        earned: dict[int, list[float | Exception]] = {seed: [] for seed in self.seeds}
        for row, (run, _) in enumerate(due):
            earned[run.history.seed].append(errors.get(row, float(returns[row])))
        measured: list[Measurement] = []

        def measure(run: GDRun) -> None:
            measured.extend(run.measured(found(value)) for value in earned[run.history.seed])

        ends += self._each(measure)
        return measured


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
