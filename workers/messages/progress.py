"""Progress of a cohort, which a worker reports every few seconds: news, and that it is alive."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from algorithms.early_end import Divergence, Failure
from algorithms.measurement import Measurement
from workers.messages.random_return import RandomReturn


class Activity(StrEnum):
    """What a worker is doing."""

    COMPILING = "compiling"
    """Loading the learner, compiling its kernels, at first use up to a minute, and resuming
    runs where they were left."""
    TRAINING = "training"
    """Past its first cycle."""


@dataclass(frozen=True)
class Resumption:
    """Where a run was resumed: at the timestep of a checkpoint, or at 0 from the start.

    mixed_with   how the machines that trained it before differ from this one; mostly empty
    note         a remark, such as on a damaged checkpoint; mostly empty
    """

    seed: int
    timestep: int
    mixed_with: tuple[str, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class CheckpointAttempt:
    """A checkpoint of a run was written or, with a problem, could not be."""

    seed: int
    timestep: int
    problem: str = ""


@dataclass(frozen=True)
class Progress:
    """News since the last report. Without any, it is a heartbeat.

    timestep      environment steps that the seeds in training have done
    training      those seeds, where others of the cohort wait for them; empty: all
    measurements  taken since the one before, of any seed of the cohort
    diverged      seeds that stopped being finite; they train no more
    failed        seeds in which code raised; they train no more
    finished      seeds that are done; they train no more
    dropped       seeds that the worker has dropped on request
    resumed       where runs were resumed, with the fingerprint and their measurements by then
    checkpoints   that were written, or could not be
    bytes_per_run memory that each run may come to fill; 0 until that is known
    fingerprint   what the bits depend on; once, before anything is trained
    random_return of the task, once, where it was asked for
    log_tail      the last lines that the worker printed, where there are new ones; else empty
    """

    timestep: int
    activity: Activity = Activity.TRAINING
    training: tuple[int, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    diverged: tuple[Divergence, ...] = ()
    failed: tuple[Failure, ...] = ()
    finished: tuple[int, ...] = ()
    dropped: tuple[int, ...] = ()
    resumed: tuple[Resumption, ...] = ()
    checkpoints: tuple[CheckpointAttempt, ...] = ()
    bytes_per_run: int = 0
    fingerprint: Mapping[str, Any] = field(default_factory=dict)
    random_return: RandomReturn | None = None
    log_tail: str = ""

    @property
    def gone(self) -> frozenset[int]:
        """The seeds that train no more."""
        diverged = (divergence.seed for divergence in self.diverged)
        failed = (failure.seed for failure in self.failed)
        return frozenset((*self.finished, *self.dropped, *diverged, *failed))

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> "Progress":
        """Read it off a report's JSON."""
        measured = document["random_return"]
        return cls(
            timestep=document["timestep"],
            activity=Activity(document["activity"]),
            training=tuple(document["training"]),
            measurements=tuple(Measurement(**entry) for entry in document["measurements"]),
            diverged=tuple(Divergence(**entry) for entry in document["diverged"]),
            failed=tuple(Failure(**entry) for entry in document.get("failed", ())),
            finished=tuple(document["finished"]),
            dropped=tuple(document["dropped"]),
            resumed=tuple(
                Resumption(**{**entry, "mixed_with": tuple(entry["mixed_with"])})
                for entry in document["resumed"]
            ),
            checkpoints=tuple(CheckpointAttempt(**entry) for entry in document["checkpoints"]),
            bytes_per_run=document["bytes_per_run"],
            fingerprint=document["fingerprint"],
            random_return=measured and RandomReturn(**measured),
            log_tail=document.get("log_tail", ""),
        )
