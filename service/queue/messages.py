"""The events that the scheduler receives, and the commands that it returns."""

from dataclasses import dataclass

from service.model.claim import Claim
from workers.messages.report import News, Report
from workers.messages.work import Work

Version = tuple[str, int]
"""An environment and the version of its numbers."""


# ---- events


@dataclass(frozen=True)
class Tick:
    """A round has begun; every report that had arrived by then was passed on before."""


@dataclass(frozen=True)
class PoolLost:
    """The pool is unavailable, or has ended. `noticed` is the time of day."""

    reason: str
    noticed: str


@dataclass(frozen=True)
class Recorded:
    """News is in the store; `held` are the runs of the claim that go on."""

    news: News
    held: frozenset[str]


@dataclass(frozen=True)
class Cancelling:
    """The running runs whose cancelling was asked for."""

    runs: frozenset[str]


@dataclass(frozen=True)
class Waiting:
    """How many runs of each cell could be claimed, and which random returns are known.

    No more than `limit` runs were counted.
    """

    cells: tuple[int, ...]
    limit: int
    random_returns: frozenset[Version]


@dataclass(frozen=True)
class Claimed:
    """The claim of a worker; None if nothing waits any more."""

    worker: str
    claim: Claim | None


QueueEvent = Report | Tick | PoolLost | Recorded | Cancelling | Waiting | Claimed


# ---- commands


@dataclass(frozen=True)
class Record:
    """Write news under a claim. Answer: Recorded."""

    claim: Claim
    news: News


@dataclass(frozen=True)
class Lose:
    """Queue the remaining runs of a claim again: its worker was lost."""

    claim: Claim
    reason: str
    log_tail: str = ""


@dataclass(frozen=True)
class Release:
    """Queue the remaining runs of a claim again at once: nothing was wrong with them."""

    claim: Claim
    reason: str


@dataclass(frozen=True)
class Fail:
    """End the remaining runs of a claim: their code raised."""

    claim: Claim
    error: str
    log_tail: str


@dataclass(frozen=True)
class LoseExpired:
    """Queue runs again whose lease has ended."""


@dataclass(frozen=True)
class AskCancelling:
    """Answer: Cancelling."""


@dataclass(frozen=True)
class AskWaiting:
    """Count waiting runs, up to a limit. Answer: Waiting."""

    limit: int


@dataclass(frozen=True)
class ClaimCohort:
    """Claim up to `limit` runs of one cell. Answer: Claimed."""

    worker: str
    lease_seconds: float
    limit: int


@dataclass(frozen=True)
class StartPool:
    """Start workers."""


@dataclass(frozen=True)
class Demand:
    """Tell the pool for how many workers there is work."""

    workers: int


@dataclass(frozen=True)
class Train:
    """Let a worker train a cohort."""

    worker: str
    work: Work


@dataclass(frozen=True)
class Drop:
    """Stop the training of these seeds by a worker."""

    worker: str
    seeds: frozenset[int]


@dataclass(frozen=True)
class Kill:
    """End a worker's process."""

    worker: str


StoreCommand = (
    Record | Lose | Release | Fail | LoseExpired | AskCancelling | AskWaiting | ClaimCohort
)
PoolCommand = StartPool | Demand | Train | Drop | Kill
Command = StoreCommand | PoolCommand
