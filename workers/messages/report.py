"""Reports of a pool of workers to its user.

A report is sent as a line: its kind, the worker's name, and its fields as JSON. A process that
forwards lines reads the first two words at most; the user of the report reads the fields, once.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from workers.messages.progress import Progress
from workers.messages.work import Work

FORMAT = 4
"""Format of the messages between service and pool. A pool that a service of another format left is
ended and not reused."""
NOBODY = "-"
"""In place of the worker in a line without one."""


@dataclass(frozen=True)
class Ready:
    """A worker is up and idle."""

    worker: str
    pid: int
    host: str


@dataclass(frozen=True)
class Busy:
    """A worker has begun a cohort: for a service that did not assign it."""

    worker: str
    work: Work


@dataclass(frozen=True)
class News:
    """A worker reported progress of its cohort."""

    worker: str
    cohort: str
    progress: Progress


@dataclass(frozen=True)
class Ended:
    """A worker has no seed left to train, and is idle again."""

    worker: str
    cohort: str


@dataclass(frozen=True)
class Failed:
    """The code that a worker ran raised; the worker is idle again. `error` is the traceback."""

    worker: str
    cohort: str
    error: str
    log_tail: str


@dataclass(frozen=True)
class Lost:
    """A worker has ended. Another one will replace it, unless its node has gone."""

    worker: str
    reason: str
    log_tail: str


@dataclass(frozen=True)
class Retired:
    """An idle or old worker was ended. Work that it was given has not begun."""

    worker: str


@dataclass(frozen=True)
class Capacity:
    """How many workers the cluster has room for now, and for how many of them there are slots.

    Told when it changes.
    """

    workers: int
    slots: int


Report = Ready | Busy | News | Ended | Failed | Lost | Retired | Capacity

KINDS: Mapping[str, type[Report]] = {
    "ready": Ready,
    "busy": Busy,
    "news": News,
    "ended": Ended,
    "failed": Failed,
    "lost": Lost,
    "retired": Retired,
    "capacity": Capacity,
}


class Heading(NamedTuple):
    """The beginning of a line, before its fields."""

    kind: str
    worker: str


def heading(line: str) -> Heading:
    """Return the heading of a line that `to_line` wrote."""
    kind, worker, _ = line.split(" ", 2)
    return Heading(kind, worker)


def to_line(report: Report) -> str:
    """Write a report as a line; `from_line` gives an equal one back (a NaN stays a NaN)."""
    kind = next(kind for kind, noun in KINDS.items() if isinstance(report, noun))
    fields = dict(vars(report))
    worker = fields.pop("worker", NOBODY)
    if isinstance(report, Busy):
        fields["work"] = report.work.to_json()
    return f"{kind} {worker} {json.dumps(fields, default=vars)}"


def from_line(line: str | bytes) -> Report:
    """Read what `to_line` wrote. Raises ValueError for anything else."""
    text = line if isinstance(line, str) else line.decode()
    try:
        kind, worker, rest = text.split(" ", 2)
        fields = json.loads(rest)
        if worker != NOBODY:
            fields["worker"] = worker
        if kind == "news":
            fields["progress"] = Progress.from_json(fields["progress"])
        elif kind == "busy":
            fields["work"] = Work.from_json(fields["work"])
        return KINDS[kind](**fields)
    except (LookupError, TypeError, AttributeError) as error:
        raise ValueError(f"no report: {error}") from error
