"""Train: one algorithm on one task, from Python.

for m in train("hybrid-ddpg", "Pendulum", seeds=range(16), timesteps=20_000):
    print(m.seed, m.timestep, m.return_mean)
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from operator import index
from typing import Any

import physics
from algorithms import catalogue
from algorithms.catalogue import Algorithm
from algorithms.early_end import DivergedError, Divergence, FailedRunsError, Failure
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.presets import LARGEST_WEIGHT, SMALLEST_WEIGHT, completed, preset
from physics.environment import Environment
from physics.kernels.compile_notice import noticed

Task = str | Environment | type[Environment]


def train(
    algorithm: str,
    environment: Task,
    seeds: Iterable[int],
    weights: tuple[float, float] | None = None,
    timesteps: int | None = None,
    config: Mapping[str, Any] | None = None,
) -> Iterator[Measurement]:
    """Train a cohort of runs, yielding each measurement as it is made.

    Args:
        algorithm: a name of `algorithms.names()`.
        environment: a task: a name that `physics.make` takes, a class or an instance.
        seeds: one run each, all different, from 0 on; a sequence or an array of integers.
        weights: (w1, w2), of the action and state gradient terms; None: the preset's. A hybrid with
            (0, 0) is its baseline, bit for bit, and a warning says so.
        timesteps: environment steps of each run; None: the preset's.
        config: settings that replace those of the preset; all others are the algorithm's defaults.

    Raises:
        ValueError: for an unknown name or an invalid value; it says what was expected.
        DivergedError: at the end, if runs diverged; the others were trained to their end.
        FailedRunsError: at the end, if code raised in some runs; the others were trained to theirs.

    The first use on a machine compiles kernels, and says so on stderr.
    """
    task = physics.as_task(environment)
    measurements = _measurements(algorithm, task, seeds, weights, timesteps, config)
    return noticed(measurements, f"{algorithm} on {task.label}")


def _measurements(
    algorithm: str,
    environment: Task,
    seeds: Iterable[int],
    weights: tuple[float, float] | None,
    timesteps: int | None,
    config: Mapping[str, Any] | None,
) -> Iterator[Measurement]:
    learner = build(algorithm, environment, seeds, weights, timesteps, config)
    divergences: list[Divergence] = []
    failures: list[Failure] = []
    while not learner.finished:
        for event in learner.advance():
            match event:
                case Measurement():
                    yield event
                case Divergence():
                    divergences.append(event)
                case Failure():
                    failures.append(event)
    if failures:
        raise FailedRunsError(failures, divergences)
    if divergences:
        raise DivergedError(divergences)


def build(
    algorithm: str,
    environment: Task,
    seeds: Iterable[int],
    weights: tuple[float, float] | None = None,
    timesteps: int | None = None,
    config: Mapping[str, Any] | None = None,
) -> Learner:
    """Build the learner that `train` advances; same arguments, and the same ValueError."""
    return prepare(algorithm, environment, seeds, weights, timesteps, config)()


def prepare(
    algorithm: str,
    environment: Task,
    seeds: Iterable[int],
    weights: tuple[float, float] | None = None,
    timesteps: int | None = None,
    config: Mapping[str, Any] | None = None,
) -> Callable[[], Learner]:
    """Check the arguments and return a function that builds the learner.

    Same arguments and ValueError as `train`. Only the returned function may compile kernels.
    """
    chosen, task = catalogue.find(algorithm), physics.as_task(environment)
    usual = preset(algorithm, task.name)
    steps = usual.timesteps if timesteps is None else timesteps
    pair = usual.weights if weights is None else weights
    settings = chosen.config_class()(**completed(algorithm, task.name, config or {}))
    check_pair(chosen, task)
    numbers, steps = seed_numbers(seeds), step_number(steps)
    check_weights(chosen, pair)
    if chosen.extends and not any(pair):
        warnings.warn(
            f"{algorithm} with weights (0, 0) matches no gradients: "
            f"it is {chosen.extends}, bit for bit",
            stacklevel=2,
        )
    return partial(chosen.load(), task, numbers, pair, steps, settings)


def check_pair(algorithm: Algorithm, environment: Environment) -> None:
    """Refuse an algorithm that the task cannot serve."""
    if algorithm.needs_reward_gradient and not environment.reward_is_differentiable:
        raise ValueError(
            f"{algorithm.name} needs the reward's gradient, and that of {environment.name} is "
            "not differentiable: choose an algorithm that learns from values, such as ddpg"
        )


def seed_numbers(seeds: Iterable[int]) -> list[int]:
    """The seeds as plain integers; refuse others, by name."""
    try:
        numbers = [index(seed) for seed in seeds]
    except TypeError:
        numbers = []
    if not numbers or len(set(numbers)) < len(numbers) or min(numbers) < 0:
        raise ValueError(f"seeds must be different integers from 0 on, not {seeds!r}")
    return numbers


def step_number(timesteps: int) -> int:
    """The timesteps as a plain integer; refuse others, by name."""
    try:
        number = index(timesteps)
    except TypeError:
        number = 0
    if number < 1:
        raise ValueError(f"timesteps must be an integer from 1 on, not {timesteps!r}")
    return number


def check_weights(algorithm: Algorithm, weights: tuple[float, float]) -> None:
    """Refuse weights out of range, by name."""
    if len(weights) != 2 or not all(
        w == 0 or SMALLEST_WEIGHT <= w <= LARGEST_WEIGHT for w in weights
    ):
        raise ValueError(
            f"weights must be two numbers, each 0 or from {SMALLEST_WEIGHT} to {LARGEST_WEIGHT}, "
            f"not {weights}"
        )
    if not algorithm.uses_weights and any(weights):
        raise ValueError(f"{algorithm.name} takes no weights, but got {weights}: give (0, 0)")
