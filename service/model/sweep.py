"""A sweep: the product of algorithms, weights, environments and seeds, posted as one."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from service.model.inquiry.search import Search


class SweepStatus(StrEnum):
    """The status of a sweep, which follows from those of its runs."""

    QUEUED = "queued"
    """No run has been claimed yet."""
    RUNNING = "running"
    """Some run is not final, or its question or search is open."""
    PAUSED = "paused"
    """No more runs are started; running ones go on to their end."""
    FINISHED = "finished"
    """Every run is final, and no question or search is open."""
    CANCELLED = "cancelled"
    """Every run is final, and the sweep was cancelled before they all ended by themselves."""


@dataclass(frozen=True)
class RunCounts:
    """The number of runs of a sweep by status."""

    queued: int = 0
    paused: int = 0
    running: int = 0
    succeeded: int = 0
    failed: int = 0
    diverged: int = 0
    cancelled: int = 0

    @property
    def total(self) -> int:
        """All runs of the sweep."""
        return self.active + self.succeeded + self.failed + self.diverged + self.cancelled

    @property
    def active(self) -> int:
        """Runs that have not ended."""
        return self.queued + self.paused + self.running


@dataclass(frozen=True)
class Sweep:
    """One sweep. Times are seconds since 1970 by the database's clock.

    owner        the name of the user who submitted it
    request      what was posted, and what was added to it since
    notes        Markdown, shown as text
    tags         in the order that they were given
    max_workers  workers that may train its runs at once; None: any number
    webhook      URL that is called at the end; None: no URL
    webhook_delivered_at  when the latest end was delivered, or given up; None: it was not
    webhook_tries         that have failed since it ended
    webhook_problem       of the last one that failed
    archived     lists leave it out unless they are asked for it
    timesteps    that its runs have trained, together
    progress     share of the asked timesteps that is done; a run that reached its end counts whole,
                 any other as far as it got
    eta_seconds  time left at the pace since the first claim; None while there is no pace or a pause
    is_asking    its question or search is open: runs may still be added, or go on
    search       as it was planned; None: it does not search
    """

    id: str
    name: str
    owner: str
    priority: int
    request: Mapping[str, Any]
    created_at: float
    started_at: float | None
    status: SweepStatus
    runs: RunCounts
    timesteps: int
    progress: float
    eta_seconds: float | None
    is_asking: bool
    search: Search | None
    notes: str
    tags: tuple[str, ...]
    archived: bool
    max_workers: int | None
    webhook: str | None
    webhook_delivered_at: float | None
    webhook_tries: int
    webhook_problem: str
