"""What a pool of workers tells the one who uses it. Each is a line of JSON on its way."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from workers.messages.progress import Progress


@dataclass(frozen=True)
class Ready:
    """A worker is up and idle."""

    worker: str
    pid: int
    host: str


@dataclass(frozen=True)
class Busy:
    """A worker has begun a cohort; `note` is that of its work."""

    worker: str
    cohort: str
    note: Mapping[str, Any]


@dataclass(frozen=True)
class News:
    """A worker said something about the cohort it trains."""

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
    """A worker is no more. Another one will be ready in its place, unless its node has gone."""

    worker: str
    reason: str
    log_tail: str


@dataclass(frozen=True)
class Retired:
    """A worker was ended that had nothing to do, or was old. What it was given has not begun."""

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


def to_line(report: Report) -> str:
    """Write a report as JSON; `from_line` gives an equal one back (a NaN stays a NaN)."""
    kind = next(kind for kind, noun in KINDS.items() if isinstance(report, noun))
    return json.dumps({"kind": kind, **asdict(report)})


def from_line(line: str | bytes) -> Report:
    """Read what `to_line` wrote. Raises ValueError for anything else."""
    try:
        fields = json.loads(line)
        kind = KINDS[fields.pop("kind")]
        if kind is News:
            return News(fields["worker"], fields["cohort"], Progress.from_json(fields["progress"]))
        return kind(**fields)
    except (LookupError, TypeError, AttributeError) as error:
        raise ValueError(f"no report: {error}") from error
