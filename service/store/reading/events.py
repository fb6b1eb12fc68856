"""The log of changes. Every change appends its event in its own transaction."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, func, select

from service.model.event import Event
from service.model.run import RunStatus
from service.model.run_name import RunName
from service.store.at_once import insert_each
from service.store.reading.rows import noun_of
from service.store.tables import events, is_there, sweeps

Change = Mapping[str, Any]


def sweep_changed(sweep_number: int, sweep_id: str, change: str) -> Change:
    """Return the entry for a sweep that was created, edited, moved, extended or answered."""
    payload = {"sweep_id": sweep_id, "change": change}
    return {"sweep_number": sweep_number, "kind": "sweep", "payload": payload}


def run_changed(
    sweep_number: int,
    run: RunName,
    *,
    status: RunStatus,
    reason: str,
    attempt: int,
    timestep: int,
) -> Change:
    """Return the entry for a run whose status or reason changed."""
    payload = {
        "sweep_id": run.sweep_id,
        "run_id": str(run),
        "status": status.value,
        "reason": reason,
        "attempt": attempt,
        "timestep": timestep,
    }
    return {"sweep_number": sweep_number, "kind": "run", "payload": payload}


def measured(sweep_number: int, runs: Sequence[RunName], first: int, last: int) -> Change:
    """Return the entry for new measurements of runs of a sweep, between timesteps, inclusive."""
    run_ids = [str(run) for run in runs]
    payload = {"sweep_id": runs[0].sweep_id, "run_ids": run_ids, "from": first, "to": last}
    return {"sweep_number": sweep_number, "kind": "measurements", "payload": payload}


def diagnosed(sweep_number: int, sweep_id: str, run_id: str | None = None) -> Change:
    """Return the entry for a diagnosis that was made; without a run, for requested ones."""
    payload = {"sweep_id": sweep_id} | ({} if run_id is None else {"run_id": run_id})
    return {"sweep_number": sweep_number, "kind": "diagnosis", "payload": payload}


def printed(sweep_number: int, sweep_id: str, runs: Sequence[RunName]) -> Change:
    """Return the entry for a worker that printed something while it trains these runs."""
    payload = {"sweep_id": sweep_id, "run_ids": [*map(str, runs)]}
    return {"sweep_number": sweep_number, "kind": "log", "payload": payload}


def append(connection: Connection, entries: Sequence[Change]) -> None:
    """Append entries in their order."""
    insert_each(connection, events, entries)


def after(
    connection: Connection, event_id: int, sweep_id: str | None = None, limit: int = 1000
) -> list[Event]:
    """Return the oldest events after one, of one sweep or of all."""
    query = (
        select(events, sweeps.c.id.label("sweep_id"))
        .join(sweeps, sweeps.c.number == events.c.sweep_number)
        .where(events.c.id > event_id)
        .order_by(events.c.id)
        .limit(limit)
    )
    if sweep_id is not None:
        number = select(sweeps.c.number).where(sweeps.c.id == sweep_id).scalar_subquery()
        query = query.where(events.c.sweep_number == number)
    return [noun_of(Event, row) for row in connection.execute(query)]


def last_id(connection: Connection) -> int:
    """Return the newest event's id, 0 when there is none."""
    return connection.scalar(select(func.max(events.c.id))) or 0


def last_id_of(connection: Connection, sweep_id: str) -> int | None:
    """Return the newest event's id of one sweep; None when there is no such sweep."""
    number = select(sweeps.c.number).where(sweeps.c.id == sweep_id, is_there).scalar_subquery()
    query = select(func.max(events.c.id)).where(events.c.sweep_number == number)
    last: int | None = connection.scalar(query)
    return last
