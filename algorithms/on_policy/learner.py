"""The on-policy loop: act, measure, learn from those steps; for a cohort of runs.

In an update, all runs first act together, each with its own policy; then each learns from its own
steps. An error in one run ends that run alone. Runs may differ in their timesteps, since episodes
may end early, and may exceed the requested number. The measurements that become due with an
update's steps are of the policy that took them.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Generic, Protocol, TypeVar

from algorithms.early_end import EarlyEnd
from algorithms.experience.evaluation import episode_returns
from algorithms.experience.rollout import start_states
from algorithms.failing_rows import call_each, early_end, found
from algorithms.history import History
from algorithms.measurement import Measurement
from algorithms.networks.policy import Policies, Policy
from algorithms.networks.shape import Shape
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State
from algorithms.stopwatch import Stopwatch
from algorithms.threads import one_thread
from physics.environment import Environment

Lived = TypeVar("Lived")
"""The steps of one run that an update learns from."""
Lived_contra = TypeVar("Lived_contra", contravariant=True)


class Run(Protocol[Lived_contra]):
    """One run of a cohort."""

    @property
    def history(self) -> History:
        """Its measurements."""

    @property
    def timestep(self) -> int:
        """Environment steps so far."""

    @property
    def updates(self) -> int:
        """Updates done so far."""

    @property
    def is_over(self) -> bool:
        """Whether nothing is left to do."""

    @property
    def nbytes(self) -> int:
        """Memory of one update."""

    def policy(self) -> Policy:
        """The current deterministic policy."""

    def count(self, lived: Lived_contra) -> None:
        """Count the steps that the coming update learns from."""

    def learn(self, lived: Lived_contra) -> None:
        """Update the networks from its steps."""

    def measured(self, return_mean: float) -> Measurement:
        """Return the next measurement, with this return."""

    def state(self) -> State:
        """All values on which its next bits depend."""

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""

    def snapshot(self) -> Snapshot:
        """The current policy."""


AnyRun = TypeVar("AnyRun", bound=Run)  # type: ignore[type-arg]  # of the other parameter


class OnPolicyLearner(ABC, Generic[AnyRun, Lived]):
    """A cohort of runs on one task; see `algorithms.learner.Learner`.

    Attributes:
        timestep: environment steps, the fewest of any run.
    """

    def __init__(
        self, environment: Environment, runs: Sequence[AnyRun], shape: Shape, timesteps: int
    ) -> None:
        """Create the cohort; `shape` is that of the actors."""
        self._environment = environment
        self._timesteps = timesteps
        self._shape = shape
        self._runs = list(runs)
        self._by_seed = {run.history.seed: run for run in runs}  # those that ended stay here
        self._stopwatch = Stopwatch({run.history.seed: run.history.cost for run in runs})
        self.timestep = 0

    @abstractmethod
    def _live(self) -> Mapping[int, Callable[[], Lived]]:
        """Act in every run; return, by seed, a function of its steps, which may raise its error."""

    @property
    def seeds(self) -> list[int]:
        """The seeds still in training."""
        return [run.history.seed for run in self._runs]

    @property
    def bytes_per_run(self) -> int:
        """Memory of one update."""
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
        self._runs = [run for run in self._runs if not run.is_over]
        self._stopwatch.keep(self.seeds)
        return [*measured, *ends]

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds."""
        self._runs = [run for run in self._runs if run.history.seed not in seeds]
        self._stopwatch.keep(self.seeds)

    def state(self, seed: int) -> State:
        """All values on which the run's next bits depend."""
        return self._by_seed[seed].state()

    def journal(self, seed: int, start: int) -> State:
        """Empty: an update needs only its own steps."""
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

    def _each(self, call: Callable[[AnyRun], None]) -> list[EarlyEnd]:
        """Call for every run; drop those for which it raises."""
        ends = call_each(
            call,
            self._runs,
            lambda run, error: early_end(run.history.seed, run.timestep, run.updates + 1, error),
        )
        self.drop({end.seed for end in ends})
        return ends

    def _learn(self, lived: Mapping[int, Callable[[], Lived]]) -> list[EarlyEnd]:
        """Let every run learn from its steps."""

        def learn(run: AnyRun) -> None:
            with self._stopwatch.training([run.history.seed]):
                run.learn(lived[run.history.seed]())

        return self._each(learn)

    def _measure(self, ends: list[EarlyEnd]) -> list[Measurement]:
        """The measurements that became due with an update's steps.

        Runs for which this raises are dropped, and their ends are added to `ends`.
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

        def measure(run: AnyRun) -> None:
            measured.extend(run.measured(found(value)) for value in earned[run.history.seed])

        ends += self._each(measure)
        return measured
