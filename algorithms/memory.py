"""Memory: what a run fills, computed from its settings before anything is built.

    replay    min(replay_size, timesteps)  x  (8 n + 4 (2 F + m + 2)  [+ 4 (F + 1)(C + m)])

The last term, the derivatives, is there where gradients are matched. Each equals its learner's
`bytes_per_run`. Nothing here is compiled, so that a process that trains nothing can ask.

Glossary: `F` features, `C` seen coordinates, `m` actions, `n` state size, `T` horizon.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

import physics
from algorithms import catalogue
from algorithms.presets import completed
from algorithms.settings import GDConfig, MPCConfig

if TYPE_CHECKING:
    from physics.environment import Environment

DOUBLE, SINGLE = 8, 4


def bytes_per_run(
    algorithm: str,
    environment: str,
    weights: tuple[float, float],
    timesteps: int,
    config: Mapping[str, Any],
) -> int:
    """Bytes of memory that a run fills; 0 if its algorithm does not say.

    Raises:
        ValueError: for an unknown name or an invalid value.
    """
    chosen = catalogue.find(algorithm)
    settings = chosen.config_class()(**completed(algorithm, environment, config))
    of_run = chosen.load_memory()
    return 0 if of_run is None else of_run(physics.make(environment), weights, timesteps, settings)


def of_replay(
    environment: "Environment", weights: tuple[float, float], timesteps: int, config: Any
) -> int:
    """A replay that has room for all that it ever has to hold."""
    features, m = environment.feature_size, environment.action_size
    columns = np.unique(environment.feature_sources).size + m
    transition = DOUBLE * environment.state_size + SINGLE * (2 * features + m + 2)
    if any(weights):
        transition += SINGLE * (features + 1) * columns
    capacity: int = min(config.replay_size, timesteps)
    return capacity * transition


def of_episodes(
    environment: "Environment", weights: tuple[float, float], timesteps: int, config: GDConfig
) -> int:
    """GD: one update's episodes, whatever the weights and timesteps."""
    del weights, timesteps
    return episode_bytes(environment, config)


def episode_bytes(environment: "Environment", config: GDConfig) -> int:
    """Episodes as they come and stacked, and the network's pass over them."""
    n, m, inputs = environment.state_size, environment.action_size, environment.feature_size
    units = config.hidden_units * config.hidden_layers
    one_step = 2 * DOUBLE * (n * (n + 2 * m + 2) + 2 * inputs) + 20 * units
    return one_step * environment.horizon * config.episodes


def of_plan(
    environment: "Environment", weights: tuple[float, float], timesteps: int, config: MPCConfig
) -> int:
    """MPC: a trajectory over the whole episode, its expansion and the gains, whatever else."""
    del weights, timesteps, config
    n, m = environment.state_size, environment.action_size
    trajectory = n + m + 1
    expansion = n * (n + m) + (n + m) + (n + m) ** 2
    gains = m + m * n
    return DOUBLE * (environment.horizon * (trajectory + expansion + gains) + n + 4)
