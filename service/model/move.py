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
    """What a move does, as its route says, and the reason that runs which it moved show."""

    description: str
    reason: str


@dataclass(frozen=True)
class Transition:
    """Between which statuses a move takes runs that no worker holds, and what is said of it.

    sources   where a run stands that is moved
    target    where it stands afterwards; in a paused sweep paused instead of queued
    change    what the sweep's event says
    none_left why a sweep cannot be moved of which no run is at the sources, nor will be
    help      of the command
    of_sweep  in words, asked of a sweep
    of_run    in words, asked of a run
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
        help="Cancel a sweep or one run; what it measured so far stays.",
        of_sweep=Words(
            "Cancel what has not ended; what was measured stays.", "its sweep was cancelled"
        ),
        of_run=Words(
            "Cancel a run: at once while it waits, by its worker while it runs.",
            "cancelled before it started",
        ),
    ),
    "pause": Transition(
        frozenset({RunStatus.QUEUED}),
        RunStatus.PAUSED,
        change="paused",
        none_left="none of its runs is left to start",
        help="Start none of the queued runs; those that are running go on to their end.",
        of_sweep=Words(
            "Start none of its runs from now on; those that are running go on to their end.",
            "its sweep is paused",
        ),
        of_run=Words("Keep a queued run from being started.", "paused"),
    ),
    "resume": Transition(
        frozenset({RunStatus.PAUSED}),
        RunStatus.QUEUED,
        change="resumed",
        none_left="none of its runs is left to start",
        help="Queue what was paused.",
        of_sweep=Words("Queue its paused runs, those that were paused alone too.", ""),
        of_run=Words("Queue a paused run.", ""),
    ),
    "retry": Transition(
        frozenset({RunStatus.FAILED}),
        RunStatus.QUEUED,
        change="retried",
        none_left="none of its runs has failed",
        help="Queue failed runs again, and only those; what they measured stays.",
        of_sweep=Words(
            "Queue its failed runs again, and only those; "
            "what they measured and their attempts stay.",
            "tried again on request",
        ),
        of_run=Words(
            "Queue a failed run again; what it measured and its attempts stay.",
            "tried again on request",
        ),
    ),
    "uncancel": Transition(
        frozenset({RunStatus.CANCELLED}),
        RunStatus.QUEUED,
        change="uncancelled",
        none_left="none of its runs was cancelled",
        help="Queue cancelled runs again, and only those; what they measured stays.",
        of_sweep=Words(
            "Queue its cancelled runs again, and only those; "
            "what they measured and their attempts stay.",
            "queued again on request",
        ),
        of_run=Words(
            "Queue a cancelled run again; what it measured and its attempts stay.",
            "queued again on request",
        ),
    ),
}
