"""What a worker says about a cohort, about once a second: news, and that it is alive."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from algorithms.measurement import Divergence, Measurement


class Activity(StrEnum):
    """What a worker is doing."""

    PREPARING = "preparing"
    """Importing the learner and compiling its kernels; up to a minute at first use."""
    TRAINING = "training"


@dataclass(frozen=True)
class Progress:
    """News since the one before. Without any it is a heartbeat.

    timestep      environment steps that every seed still training has done
    measurements  taken since the one before, of any seed of the cohort
    diverged      seeds that stopped being finite; they train no more
    finished      seeds that are done; they train no more
    dropped       seeds that the worker was told to drop and has dropped
    fingerprint   versions, processor and code that the bits depend on; in the first one only
    """

    timestep: int
    activity: Activity = Activity.TRAINING
    measurements: tuple[Measurement, ...] = ()
    diverged: tuple[Divergence, ...] = ()
    finished: tuple[int, ...] = ()
    dropped: tuple[int, ...] = ()
    fingerprint: Mapping[str, Any] = field(default_factory=dict)
