"""Presets: the settings the evaluation uses, per algorithm and task, and what chose them.

A submission that names no setting gets these.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Preset:
    """The settings of one algorithm on one task.

    Attributes:
        weights: (w1, w2), of the action and state gradient terms.
        timesteps: environment steps of a run.
        config: settings other than the algorithm's defaults.
    """

    weights: tuple[float, float] = (0.0, 0.0)
    timesteps: int = 40_000
    config: Mapping[str, Any] = field(default_factory=dict)


PRESETS: dict[tuple[str, str], Preset] = {}


def preset(algorithm: str, environment: str) -> Preset:
    """The preset of an algorithm on a task, or the defaults where none was chosen."""
    return PRESETS.get((algorithm, environment), Preset())
