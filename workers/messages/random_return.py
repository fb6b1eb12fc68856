"""The zero of the normalised scale: what uniform random actions earn in a task.

normalised = (return - random) / (max_reward T - random)
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class RandomReturn:
    """Mean return of uniform random actions in one version of a task, with its 95 % interval."""

    environment: str
    version: int
    mean: float
    low: float
    high: float
    episodes: int
