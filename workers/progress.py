"""What a worker says about a cohort, about once a second: news, and that it is alive."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from algorithms.measurement import Divergence, Measurement
from workers.random_return import RandomReturn


class Activity(StrEnum):
    """What a worker is doing."""

    COMPILING = "compiling"
    """Loading the learner and compiling its kernels, at first use up to a minute."""
    TRAINING = "training"
    """Past its first cycle."""


@dataclass(frozen=True)
class Progress:
    """News since the one before. Without any it is a heartbeat.

    timestep      environment steps that every seed still training has done
    measurements  taken since the one before, of any seed of the cohort
    diverged      seeds that stopped being finite; they train no more
    finished      seeds that are done; they train no more
    dropped       seeds that the worker was told to drop and has dropped
    fingerprint   what the bits depend on; in the first one only
    random_return of the task, once, where it was asked for
    """

    timestep: int
    activity: Activity = Activity.TRAINING
    measurements: tuple[Measurement, ...] = ()
    diverged: tuple[Divergence, ...] = ()
    finished: tuple[int, ...] = ()
    dropped: tuple[int, ...] = ()
    fingerprint: Mapping[str, Any] = field(default_factory=dict)
    random_return: RandomReturn | None = None

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Progress":
        """Read what `dataclasses.asdict` made, also after a trip through JSON text."""
        measured = document["random_return"]
        return cls(
            timestep=document["timestep"],
            activity=Activity(document["activity"]),
            measurements=tuple(Measurement(**entry) for entry in document["measurements"]),
            diverged=tuple(Divergence(**entry) for entry in document["diverged"]),
            finished=tuple(document["finished"]),
            dropped=tuple(document["dropped"]),
            fingerprint=document["fingerprint"],
            random_return=measured and RandomReturn(**measured),
        )
