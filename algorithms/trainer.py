"""Train: one algorithm on one task, from Python.

training = train("hybrid-ddpg", "Pendulum", seeds=range(16), timesteps=20_000)
for m in training:
    print(m.seed, m.timestep, m.return_mean)
policy = training.policy(seed=0)
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import asdict
from functools import cached_property
from typing import Any, Self

from algorithms.acting.policy import TrainedPolicy, policy_of
from algorithms.catalogue import Algorithm
from algorithms.early_end import DivergedError, Divergence, EarlyEnd, FailedRunsError, Failure
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.snapshot import Snapshot
from algorithms.training import Task, prepare
from physics.kernels.compile_notice import noticed

Callback = Callable[[Measurement], bool | None]
"""A function that is called with every measurement; True stops the run of the measurement."""


class Trainer(Iterator[Measurement]):
    """A cohort of runs in training: an iterator over their measurements, with their policies.

    Training continues while you iterate, and pauses otherwise. You can leave the loop at any time:
    `policy` returns the policy learned so far, and a second loop continues.

    Attributes:
        measurements: all measurements so far.
        ended: by seed, how a run ended early.
    """

    def __init__(
        self,
        algorithm: str | Algorithm,
        environment: Task,
        seeds: Iterable[int],
        weights: tuple[float, float] | None = None,
        timesteps: int | None = None,
        config: Mapping[str, Any] | None = None,
        callback: Callback | None = None,
    ) -> None:
        """Check the arguments, which are those of `train`; the first iteration compiles.

        Raises:
            ValueError: for an unknown name or an invalid value; it says what was expected.
        """
        self.measurements: list[Measurement] = []
        self.ended: dict[int, EarlyEnd] = {}
        self._prepared = prepare(algorithm, environment, seeds, weights, timesteps, config)
        self._callback = callback
        self._measured = noticed(self._train(), self._prepared.title)
        self._stopped: dict[int, Snapshot | None] = {}

    def __iter__(self) -> Self:
        """Itself."""
        return self

    def __next__(self) -> Measurement:
        """The next measurement; trains until there is one.

        Raises:
            DivergedError, FailedRunsError: at the end, as `train`.
        """
        measurement = next(self._measured)
        self.measurements.append(measurement)
        if self._callback is not None and self._callback(measurement):
            self.stop([measurement.seed])
        return measurement

    def run(self) -> list[Measurement]:
        """Train to the end; return all measurements.

        Raises:
            DivergedError, FailedRunsError: as `train`.
        """
        for _ in self:
            pass
        return self.measurements

    def stop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds; their policies stay as they are now."""
        chosen = set(self._learner.seeds) & set(seeds)
        self._stopped |= {seed: self._learner.snapshot(seed) for seed in chosen}
        self._learner.drop(chosen)

    def policy(self, seed: int | None = None) -> TrainedPolicy:
        """The policy of a run as it is now.

        The policy of an on-policy learner is one update ahead of its last measurement.

        Args:
            seed: the seed of the run; not needed if there is only one.

        Raises:
            ValueError: for another seed, for a run that ended early, and for an algorithm that
                learns no policy.
        """
        prepared = self._prepared
        asked = list(prepared.seeds) if seed is None else [seed]
        if len(asked) > 1 or asked[0] not in prepared.seeds:
            raise ValueError(f"seed must be one of {prepared.seeds}, not {seed}")
        [chosen] = asked
        if chosen in self.ended:
            raise ValueError(f"there is no policy of seed {chosen}: {self.ended[chosen].reason}")
        snapshot = (
            self._stopped[chosen] if chosen in self._stopped else self._learner.snapshot(chosen)
        )
        if snapshot is None:
            raise ValueError(f"{prepared.algorithm.name} learns no policy: choose another learner")
        origin = {
            "algorithm": prepared.algorithm.name,
            "weights": list(prepared.weights),
            "config": asdict(prepared.config),
            "seed": chosen,
        }
        return policy_of(snapshot, prepared.environment, origin)

    @cached_property
    def _learner(self) -> Learner:
        return self._prepared()

    def _train(self) -> Iterator[Measurement]:
        while not self._learner.finished:
            for event in self._learner.advance():
                if not isinstance(event, Measurement):
                    self.ended[event.seed] = event
                elif event.seed not in self._stopped:
                    yield event
        divergences = [end for end in self.ended.values() if isinstance(end, Divergence)]
        failures = [end for end in self.ended.values() if isinstance(end, Failure)]
        if failures:
            raise FailedRunsError(failures, divergences)
        if divergences:
            raise DivergedError(divergences)


def train(
    algorithm: str | Algorithm,
    environment: Task,
    seeds: Iterable[int],
    weights: tuple[float, float] | None = None,
    timesteps: int | None = None,
    config: Mapping[str, Any] | None = None,
    callback: Callback | None = None,
) -> Trainer:
    """Train a cohort of runs, yielding each measurement as it is made.

    Args:
        algorithm: a name of `algorithms.names()`, or an `Algorithm` of your own.
        environment: a task: a name that `physics.make` takes, a class or an instance.
        seeds: one run each, all different, from 0 on; a sequence or an array of integers.
        weights: (w1, w2), those of the action and state gradient terms; None for the preset's. A
            hybrid with (0, 0) is its baseline, bit for bit, and a warning says so.
        timesteps: environment steps of each run; None for the preset's.
        config: settings that replace those of the preset; all others are the algorithm's defaults.
        callback: a function called with each measurement; if it returns True, the run of that seed
            stops, and its policy stays as it is.

    Returns:
        The iterator, which also gives the policies: `train(...).policy(seed)`.

    Raises:
        ValueError: for an unknown name or an invalid value; it says what was expected.
        DivergedError: at the end, if runs diverged; the others were trained to their end.
        FailedRunsError: at the end, if code raised in some runs; the others were trained to theirs.

    The first use on a machine compiles kernels, and says so on stderr.
    """
    return Trainer(algorithm, environment, seeds, weights, timesteps, config, callback)
