"""Sweeps: creating one with all its runs, reading them with counts."""

import json
import secrets
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Row,
    Select,
    case,
    func,
    insert,
    select,
)

from service.model.caller import ADMINISTRATOR
from service.model.inquiry.search import Search
from service.model.run import ACTIVE, RunStatus
from service.model.sweep import RunCounts, Sweep, SweepStatus
from service.store.column_types import now
from service.store.reading import events, random_returns, sweep_names
from service.store.reading.rows import noun_of
from service.store.reading.runs import columns_of
from service.store.reading.sweep_search import EVERY, SweepSearch
from service.store.refusal import NotFoundError, SubmissionKeyReusedError
from service.store.tables import is_there, runs, sweeps
from workers.messages.run_spec import RunSpec


def create(
    connection: Connection,
    name: str,
    priority: int,
    request: Mapping[str, Any],
    specs: Sequence[RunSpec],
    *,
    entries: Sequence[int] | None = None,
    notes: str = "",
    tags: Sequence[str] = (),
    max_workers: int | None = None,
    webhook: str | None = None,
    environment_versions: Mapping[str, int],
    submission_key: str | None = None,
    owner: str = ADMINISTRATOR,
    search: Search | None = None,
) -> Sweep:
    """Write a sweep and its runs, which are numbered in the order of the specs.

    `entries` are the places of the specs' entries; without them, all are of the first. The versions
    are those of the specs' environments. If the owner has submitted a sweep with that key
    already, return that sweep. Raises SubmissionKeyReusedError if its request or owner differs.
    """
    if not specs:
        raise ValueError("a sweep has at least one run, got none")
    if submission_key is not None:
        earlier = _submitted(connection, submission_key, request, owner)
        if earlier is not None:
            return earlier
    sweep_id = secrets.token_hex(6)
    heading = insert(sweeps).values(
        id=sweep_id,
        name=name,
        priority=priority,
        request=request,
        submission_key=submission_key,
        question="open" if request.get("question") or search else None,
        search=None if search is None else search.document,
        notes=notes,
        max_workers=max_workers,
        webhook=webhook,
        owner=owner,
    )
    number = connection.execute(heading.returning(sweeps.c.number)).scalar_one()
    connection.execute(
        insert(runs), _rows(number, specs, entries or [0] * len(specs), environment_versions)
    )
    sweep_names.add(connection, number, "tag", tags)
    sweep_names.add(connection, number, "algorithm", [spec.algorithm for spec in specs])
    sweep_names.add(connection, number, "environment", [spec.environment for spec in specs])
    events.append(connection, [events.sweep_changed(number, sweep_id, "created")])
    return get(connection, sweep_id)


def _rows(
    sweep_number: int,
    specs: Sequence[RunSpec],
    entries: Sequence[int],
    environment_versions: Mapping[str, int],
) -> list[dict[str, Any]]:
    """The runs of a sweep as rows, numbered in the order of the specs."""
    cells = {cell: index for index, cell in enumerate(dict.fromkeys(s.cell for s in specs))}
    return [
        {
            "sweep_number": sweep_number,
            "ordinal": ordinal,
            "cell": cells[spec.cell],
            "entry": entry,
            "environment_version": environment_versions[spec.environment],
            **columns_of(spec),
        }
        for ordinal, (spec, entry) in enumerate(zip(specs, entries, strict=True))
    ]


def _submitted(
    connection: Connection, key: str, request: Mapping[str, Any], owner: str
) -> Sweep | None:
    query = select(sweeps).where(sweeps.c.submission_key == key)
    row = connection.execute(query).one_or_none()
    if row is None:
        return None
    if row.owner != owner:
        raise SubmissionKeyReusedError(f"{row.owner} has submitted a sweep under this key")
    # As text, since to Python 1, 1.0 and True are equal.
    asked, now_asked = (json.dumps(document, sort_keys=True) for document in (row.request, request))
    if asked != now_asked:
        raise SubmissionKeyReusedError(
            f"sweep {row.id} was submitted under this key with another request"
        )
    return get(connection, row.id)


def find(connection: Connection, sweep_id: str) -> Sweep | None:
    """Return one sweep, or None."""
    row = connection.execute(_summaries(named(sweep_id))).one_or_none()
    if row is None:
        return None
    return _sweep(row, sweep_names.tags(connection, [row.number]))


def get(connection: Connection, sweep_id: str) -> Sweep:
    """Return one sweep. Raises NotFoundError."""
    sweep = find(connection, sweep_id)
    if sweep is None:
        raise NotFoundError(f"there is no sweep {sweep_id!r}")
    return sweep


def request(connection: Connection, sweep_id: str) -> Mapping[str, Any]:
    """Return the request of a sweep. Raises NotFoundError."""
    posted = connection.scalar(select(sweeps.c.request).where(named(sweep_id)))
    if posted is None:
        raise NotFoundError(f"there is no sweep {sweep_id!r}")
    found: Mapping[str, Any] = posted
    return found


def owners(connection: Connection, sweep_ids: Collection[str]) -> dict[str, str]:
    """Return the owners of those sweeps that exist."""
    query = select(sweeps.c.id, sweeps.c.owner).where(sweeps.c.id.in_(sweep_ids), is_there)
    return {row.id: row.owner for row in connection.execute(query)}


def named(sweep_id: str) -> ColumnElement[bool]:
    """Return the condition that picks one sweep by its id, unless it is deleted."""
    return (sweeps.c.id == sweep_id) & is_there


def version(connection: Connection, sweep_id: str) -> str | None:
    """Return a text that changes with everything shown of a sweep; None: no such sweep."""
    last = events.last_id_of(connection, sweep_id)
    zeros = random_returns.last_measured_at(connection)
    return None if last is None else f"{last}-{zeros!r}"


def page(
    connection: Connection,
    after: str | None = None,
    limit: int = 50,
    search: SweepSearch = EVERY,
) -> list[Sweep]:
    """Return sweeps that a search finds, newest first, beginning after the one named `after`."""
    found = select(sweeps.c.number).where(is_there, *search.conditions())
    found = found.order_by(sweeps.c.number.desc()).limit(limit)
    if after is not None:
        last = select(sweeps.c.number).where(sweeps.c.id == after).scalar_subquery()
        found = found.where(sweeps.c.number < last)
    numbers = list(connection.scalars(found))
    query = _summaries(sweeps.c.number.in_(numbers)).order_by(sweeps.c.number.desc())
    tags = sweep_names.tags(connection, numbers)
    return [_sweep(row, tags) for row in connection.execute(query)]


def searches(connection: Connection) -> list[Sweep]:
    """Return the sweeps that search, the oldest first."""
    query = _summaries(is_there & sweeps.c.search.is_not(None)).order_by(sweeps.c.number)
    return [_sweep(row, {}) for row in connection.execute(query)]


def _summaries(condition: ColumnElement[bool]) -> Select[Any]:
    """Sweeps with sums over their runs."""
    counts = [
        func.count().filter(runs.c.status == status).label(status.value) for status in RunStatus
    ]
    succeeded = runs.c.status == RunStatus.SUCCEEDED
    done = case((succeeded, runs.c.timesteps), else_=runs.c.timestep)
    left = case((runs.c.status.in_(ACTIVE), runs.c.timesteps - runs.c.timestep), else_=0)
    return (
        select(
            sweeps,
            *counts,
            func.min(runs.c.started_at).label("started_at"),
            func.coalesce(func.sum(done), 0).label("done"),
            func.coalesce(func.sum(left), 0).label("left"),
            func.coalesce(func.sum(runs.c.timesteps), 0).label("asked"),
            now().label("clock"),
        )
        .join(runs, runs.c.sweep_number == sweeps.c.number)
        .where(condition)
        .group_by(sweeps.c.number)
    )


def _sweep(row: Row[Any], tags: Mapping[int, Sequence[str]]) -> Sweep:
    counts = RunCounts(**{status.value: getattr(row, status.value) for status in RunStatus})
    is_asking = row.question == "open" and row.cancelled_at is None
    search = Search.of(row.search)
    # The rungs to come are known; the batches of a question are not.
    to_come = max(search.timesteps - row.asked, 0) if search and is_asking else 0
    eta = None
    if counts.active == 0 and not to_come:
        eta = None if is_asking else 0.0
    elif row.started_at is not None and row.done > 0 and counts.paused == 0:
        eta = (row.clock - row.started_at) * float(row.left + to_come) / float(row.done)
    return noun_of(
        Sweep,
        row,
        status=_status(counts, row, is_asking=is_asking),
        is_asking=is_asking,
        search=search,
        runs=counts,
        timesteps=int(row.done),
        progress=float(row.done) / float(row.asked + to_come),
        eta_seconds=eta,
        tags=tuple(tags.get(row.number, ())),
        archived=row.archived_at is not None,
    )


def _status(counts: RunCounts, row: Row[Any], *, is_asking: bool) -> SweepStatus:
    if counts.active == 0 and not is_asking:
        was_cut = row.cancelled_at is not None and (counts.cancelled > 0 or row.question == "open")
        return SweepStatus.CANCELLED if was_cut else SweepStatus.FINISHED
    if row.paused_at is not None or 0 < counts.paused == counts.active:
        return SweepStatus.PAUSED
    return SweepStatus.QUEUED if row.started_at is None else SweepStatus.RUNNING
