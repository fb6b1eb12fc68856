"""Training: checks names and values, and builds a learner from them."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from difflib import get_close_matches
from operator import index
from typing import Any

import numpy as np
from pydantic import ValidationError

import physics
from algorithms import catalogue
from algorithms.catalogue import Algorithm
from algorithms.learner import Learner
from algorithms.presets import LARGEST_WEIGHT, SMALLEST_WEIGHT, completed, preset
from algorithms.settings import SettingsError
from physics.environment import Environment

Task = str | Environment | type[Environment]


@dataclass(frozen=True)
class Prepared:
    """A cohort of runs that can be built: every argument has been checked."""

    algorithm: Algorithm
    environment: Environment
    seeds: Sequence[int]
    weights: tuple[float, float]
    timesteps: int
    config: Any
    """The settings, of the algorithm's own class."""

    def __call__(self) -> Learner:
        """Build the learner; this may compile kernels."""
        learner: Learner = self.algorithm.load()(
            self.environment, self.seeds, self.weights, self.timesteps, self.config
        )
        return learner

    @property
    def title(self) -> str:
        """A title: the algorithm and the task."""
        return f"{self.algorithm.name} on {self.environment.label}"


def build(
    algorithm: str | Algorithm,
    environment: Task,
    seeds: Iterable[int],
    weights: tuple[float, float] | None = None,
    timesteps: int | None = None,
    config: Mapping[str, Any] | None = None,
) -> Learner:
    """Build the learner that `train` advances; arguments and ValueError are those of `train`."""
    return prepare(algorithm, environment, seeds, weights, timesteps, config)()


def prepare(
    algorithm: str | Algorithm,
    environment: Task,
    seeds: Iterable[int],
    weights: tuple[float, float] | None = None,
    timesteps: int | None = None,
    config: Mapping[str, Any] | None = None,
) -> Prepared:
    """Check the arguments; calling what this returns builds the learner.

    The arguments and ValueError are those of `train`. Nothing is compiled before that call.
    """
    chosen, task = catalogue.find(algorithm), physics.as_task(environment)
    usual = preset(chosen.name, task.name)
    steps = usual.timesteps if timesteps is None else timesteps
    pair = usual.weights if weights is None else weights
    settings = checked_settings(chosen, completed(chosen.name, task.name, config or {}))
    check_pair(chosen, task)
    numbers, steps = seed_numbers(seeds), step_number(steps)
    check_weights(chosen, pair)
    if chosen.extends and not any(pair):
        warnings.warn(
            f"{chosen.name} with weights (0, 0) matches no gradients: "
            f"it is {chosen.extends}, bit for bit",
            stacklevel=2,
        )
    return Prepared(chosen, task, numbers, pair, steps, settings)


def checked_settings(algorithm: Algorithm, given: Mapping[str, Any]) -> Any:
    """The settings, of the algorithm's own class. Raises SettingsError."""
    settings = algorithm.config_class()
    try:
        return settings(**given)
    except ValidationError as refusal:
        known = [field.name for field in fields(settings)]
        mistakes = [_mistake(error, known) for error in refusal.errors()]
        raise SettingsError(f"{algorithm.name}: {'; '.join(mistakes)}") from refusal


def _mistake(error: Mapping[str, Any], known: Sequence[str]) -> str:
    """The mistake in one setting, as a sentence."""
    name = ".".join(map(str, error["loc"]))
    if error["type"] != "unexpected_keyword_argument":
        return f"{name}: {error['msg']}, not {error['input']!r}"
    near = get_close_matches(name, known, n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"there is no setting {name!r}{hint} (known: {', '.join(known)})"


def check_pair(algorithm: Algorithm, environment: Environment) -> None:
    """Refuse an algorithm that cannot learn on the task."""
    if algorithm.needs_reward_gradient and not environment.reward_is_differentiable:
        raise ValueError(
            f"{algorithm.name} needs the reward's gradient, and that of {environment.name} is "
            "not differentiable: choose an algorithm that learns from values, such as ddpg"
        )


def seed_numbers(seeds: Iterable[int]) -> list[int]:
    """The seeds as plain integers. Raises ValueError for others."""
    try:
        numbers = [index(seed) for seed in seeds]
    except TypeError:
        numbers = []
    if not numbers or len(set(numbers)) < len(numbers) or min(numbers) < 0:
        raise ValueError(f"seeds must be different integers from 0 on, not {seeds!r}")
    return numbers


def step_number(timesteps: int) -> int:
    """The timesteps as a plain integer. Raises ValueError for others."""
    try:
        number = index(timesteps)
    except TypeError:
        number = 0
    if number < 1:
        raise ValueError(f"timesteps must be an integer from 1 on, not {timesteps!r}")
    return number


def check_weights(algorithm: Algorithm, weights: tuple[float, float]) -> None:
    """Raise ValueError for weights out of range."""
    if np.shape(weights) != (2,) or not all(
        w == 0 or SMALLEST_WEIGHT <= w <= LARGEST_WEIGHT for w in weights
    ):
        raise ValueError(
            f"weights must be two numbers, each 0 or from {SMALLEST_WEIGHT} to {LARGEST_WEIGHT}, "
            f"not {weights}"
        )
    if not algorithm.uses_weights and any(weights):
        raise ValueError(f"{algorithm.name} takes no weights, but got {weights}: give (0, 0)")
