"""A run of a sweep, as the store knows it, and the states it goes through.

paused <-> queued -> running -> succeeded | failed | diverged | cancelled
              ^---------'  (its worker was lost, or its lease expired)
              ^--------------------------'  (somebody asked for it: a retry of what failed or was
                                             cancelled, more timesteps for what succeeded)
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from workers.messages.run_spec import RunSpec


class RunStatus(StrEnum):
    """The status of a run. Final states change only on request of a user."""

    QUEUED = "queued"
    """Waits for a worker. Also after a worker was lost, with the reason and a later start."""
    PAUSED = "paused"
    """Waits for somebody to resume it or its sweep."""
    RUNNING = "running"
    """Claimed: one worker holds its lease under the current attempt."""
    SUCCEEDED = "succeeded"
    """Reached its timesteps."""
    FAILED = "failed"
    """An error in code, or lost too many workers in a row; the attempts say which."""
    DIVERGED = "diverged"
    """A loss or parameter stopped being finite. This would recur, so it is never tried again."""
    CANCELLED = "cancelled"
    """Somebody asked for it."""

    @property
    def is_final(self) -> bool:
        """Whether the run has ended."""
        return self not in ACTIVE


ACTIVE = frozenset({RunStatus.QUEUED, RunStatus.PAUSED, RunStatus.RUNNING})
FINAL = frozenset(RunStatus) - ACTIVE


def unfinished(statuses: Iterable[RunStatus]) -> dict[str, int]:
    """Count the runs that have not reached their end, by status; zeros are left out."""
    counts = Counter(statuses)
    others = (status for status in RunStatus if status is not RunStatus.SUCCEEDED)
    return {status.value: counts[status] for status in others if counts[status]}


@dataclass(frozen=True)
class Run:
    """One run. Times are seconds since 1970 by the database's clock.

    entry               the place of its entry among those of its sweep
    attempt             how often it was claimed; writes under an older number are refused
    timestep            environment steps reached by the current attempt
    reason              why it has its status, a sentence; empty while all is well
    is_cancelling       cancelling was asked for and its worker has not stopped yet
    environment_version version of the task's numbers under which it was submitted
    fingerprint         of the machine and code that trains it; None before the first report
    checkpoint_timestep of its newest checkpoint; 0 where there is none, as after its end
    resumed_timestep    where the current attempt took over; None until its worker reports
    memory_bytes        that it may need in its worker; None until that is known
    worked_seconds      how long workers have worked on it, waits between attempts left out; None
                        before the first attempt has ended
    score               its final score, raw; NaN unless it succeeded
    """

    id: str
    sweep_id: str
    spec: RunSpec
    entry: int
    environment_version: int
    status: RunStatus
    reason: str
    attempt: int
    timestep: int
    is_cancelling: bool
    created_at: float
    started_at: float | None
    finished_at: float | None
    fingerprint: Mapping[str, Any] | None
    checkpoint_timestep: int
    resumed_timestep: int | None
    memory_bytes: int | None
    worked_seconds: float | None
    score: float


@dataclass(frozen=True)
class Attempt:
    """One claim of a run and how it ended.

    outcome is "running", "succeeded", "failed", "diverged", "cancelled" or "lost" (the worker or
    its lease); error is a traceback or a sentence, log_tail the last lines that the worker printed
    while it trained the run and those of its cohort.
    resumed_timestep is where it took over, note is a remark on its checkpoints.
    """

    attempt: int
    worker: str
    outcome: str
    error: str
    log_tail: str
    started_at: float
    ended_at: float | None
    fingerprint: Mapping[str, Any] | None
    resumed_timestep: int | None
    note: str
