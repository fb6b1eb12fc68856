"""Memory: the bytes that a run fills, computed from its settings before anything is built.

    replay    min(replay_size, timesteps)  x  (8 n + 4 (2 F + m + 2)  [+ 4 (F + 1)(C + m)])

The last term, the derivatives, exists only where gradients are matched. Each result equals its
learner's `bytes_per_run`. Nothing here is compiled, so that a process that does not train can call
it.

Glossary: `F` features, `C` seen coordinates, `m` actions, `n` state size, `T` horizon.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

import physics
from algorithms import catalogue
from algorithms.presets import completed
from algorithms.settings import GDConfig, MPCConfig, PPOConfig, SHACConfig

DOUBLE, SINGLE = 8, 4


class Sizes(Protocol):
    """The sizes of a task: those of the task itself, or of an object with its constants."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def state_size(self) -> int:
        """n."""

    @property
    def action_size(self) -> int:
        """m."""

    @property
    def feature_size(self) -> int:
        """F."""

    @property
    def feature_sources(self) -> Sequence[int] | NDArray[np.int64]:
        """[F], the one coordinate that each feature depends on."""

    @property
    def horizon(self) -> int:
        """T."""


def bytes_per_run(
    algorithm: str,
    environment: str | Sizes,
    weights: tuple[float, float],
    timesteps: int,
    config: Mapping[str, Any],
) -> int:
    """Bytes of memory that a run fills; 0 if its algorithm does not specify them.

    Raises:
        ValueError: for an unknown name or an invalid value.
    """
    chosen = catalogue.find(algorithm)
    sizes = physics.make(environment) if isinstance(environment, str) else environment
    settings = chosen.config_class()(**completed(algorithm, sizes.name, config))
    of_run = chosen.load_memory()
    return 0 if of_run is None else of_run(sizes, weights, timesteps, settings)


def of_replay(environment: Sizes, weights: tuple[float, float], timesteps: int, config: Any) -> int:
    """The size of a replay with room for all transitions that it will hold."""
    features, m = environment.feature_size, environment.action_size
    columns = np.unique(environment.feature_sources).size + m
    transition = DOUBLE * environment.state_size + SINGLE * (2 * features + m + 2)
    if any(weights):
        transition += SINGLE * (features + 1) * columns
    capacity: int = min(config.replay_size, timesteps)
    return capacity * transition


def of_episodes(
    environment: Sizes, weights: tuple[float, float], timesteps: int, config: GDConfig
) -> int:
    """GD: one update's episodes, independent of weights and timesteps."""
    del weights, timesteps
    return episode_bytes(environment, config)


def episode_bytes(environment: Sizes, config: GDConfig) -> int:
    """The episodes as collected and as stacked, and the network's pass over them."""
    n, m, inputs = environment.state_size, environment.action_size, environment.feature_size
    units = config.hidden_units * config.hidden_layers
    one_step = 2 * DOUBLE * (n * (n + 2 * m + 2) + 2 * inputs) + 20 * units
    return one_step * environment.horizon * config.episodes


def of_linearized_window(
    environment: Sizes, weights: tuple[float, float], timesteps: int, config: SHACConfig
) -> int:
    """SHAC: one window, independent of weights and timesteps."""
    del weights, timesteps
    return window_bytes(environment, config, linearized=True)


def of_window(
    environment: Sizes, weights: tuple[float, float], timesteps: int, config: PPOConfig
) -> int:
    """PPO: one window without derivatives, independent of weights and timesteps."""
    del weights, timesteps
    return window_bytes(environment, config, linearized=False)


def window_bytes(environment: Sizes, config: Any, *, linearized: bool) -> int:
    """A window as collected, as stacked and of one run alone, and the networks' passes over it."""
    n, m, inputs = environment.state_size, environment.action_size, environment.feature_size
    units = config.hidden_units * config.hidden_layers
    one_step = 3 * (DOUBLE * (2 * inputs + 1) + SINGLE * m + 2) + 20 * units
    if linearized:
        one_step += 3 * DOUBLE * (n * (n + 2 * m + 2) + 2 * inputs)
    return int(one_step * config.window * config.environments)


def of_plan(
    environment: Sizes, weights: tuple[float, float], timesteps: int, config: MPCConfig
) -> int:
    """MPC: a trajectory over the whole episode, its expansion and the gains, in all cases."""
    del weights, timesteps, config
    n, m = environment.state_size, environment.action_size
    trajectory = n + m + 1
    expansion = n * (n + m) + (n + m) + (n + m) ** 2
    gains = m + m * n
    return DOUBLE * (environment.horizon * (trajectory + expansion + gains) + n + 4)
