"""What users ask of sweeps and runs: cancel, pause, resume, retry, uncancel.

`TRANSITIONS` is the one list of them: the store, the API and the command line follow it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from service.model.run import RunStatus

Move = Literal["cancel", "pause", "resume", "retry", "uncancel"]


@dataclass(frozen=True)
class Words:
    """What a move does, for its route, and the reason that moved runs show."""

    description: str
    reason: str


@dataclass(frozen=True)
class Transition:
    """The statuses between which a move takes runs that no worker holds, and its texts.

    sources   statuses of the runs that are moved
    target    their status afterwards; in a paused sweep paused instead of queued
    change    the change in the sweep's event
    none_left why a sweep cannot be moved that has no run at the sources, and will have none
    help      help text of the command
    of_sweep  texts of the move of a sweep
    of_run    texts of the move of a run
    """

    sources: frozenset[RunStatus]
    target: RunStatus
    change: str
    none_left: str
    help: str
    of_sweep: Words
    of_run: Words


TRANSITIONS: Mapping[Move, Transition] = {
    "cancel": Transition(
        frozenset({RunStatus.QUEUED, RunStatus.PAUSED}),
        RunStatus.CANCELLED,
        change="cancelled",
        none_left="none of its runs is left to cancel",
        help="Cancel a sweep or a run; its measurements stay.",
        of_sweep=Words(
            "Cancel the runs that have not ended; measurements stay.", "its sweep was cancelled"
        ),
        of_run=Words(
            "Cancel a run: at once if it waits, through its worker if it is running.",
            "cancelled before it started",
        ),
    ),
    "pause": Transition(
        frozenset({RunStatus.QUEUED}),
        RunStatus.PAUSED,
        change="paused",
        none_left="none of its runs is left to start",
        help="Start no queued runs; running ones go on to their end.",
        of_sweep=Words(
            "Start no more runs of the sweep; running ones go on to their end.",
            "its sweep is paused",
        ),
        of_run=Words("Keep a queued run from starting.", "paused"),
    ),
    "resume": Transition(
        frozenset({RunStatus.PAUSED}),
        RunStatus.QUEUED,
        change="resumed",
        none_left="none of its runs is left to start",
        help="Queue paused runs again.",
        of_sweep=Words(
            "Queue the paused runs of the sweep, including those that were paused alone.", ""
        ),
        of_run=Words("Queue a paused run.", ""),
    ),
    "retry": Transition(
        frozenset({RunStatus.FAILED}),
        RunStatus.QUEUED,
        change="retried",
        none_left="none of its runs has failed",
        help="Queue failed runs again, and only those; their measurements stay.",
        of_sweep=Words(
            "Queue the failed runs of the sweep again, and only those; "
            "their measurements and attempts stay.",
            "tried again on request",
        ),
        of_run=Words(
            "Queue a failed run again; its measurements and attempts stay.",
            "tried again on request",
        ),
    ),
    "uncancel": Transition(
        frozenset({RunStatus.CANCELLED}),
        RunStatus.QUEUED,
        change="uncancelled",
        none_left="none of its runs was cancelled",
        help="Queue cancelled runs again, and only those; their measurements stay.",
        of_sweep=Words(
            "Queue the cancelled runs of the sweep again, and only those; "
            "their measurements and attempts stay.",
            "queued again on request",
        ),
        of_run=Words(
            "Queue a cancelled run again; its measurements and attempts stay.",
            "queued again on request",
        ),
    ),
}
