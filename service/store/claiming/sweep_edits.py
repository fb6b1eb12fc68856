"""Edits of a sweep, at any time: its name, notes and tags, its priority."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, select, update

from service.model.sweep import Sweep
from service.store.column_types import now
from service.store.reading import events, sweep_names
from service.store.reading.sweeps import get
from service.store.tables import sweeps


def edit(connection: Connection, sweep_id: str, changes: Mapping[str, Any]) -> Sweep:
    """Change fields of a sweep, by their names in `Sweep`. Raises NotFoundError.

    A change to equal values is not an event.
    """
    before = get(connection, sweep_id)
    changed = {name: value for name, value in changes.items() if getattr(before, name) != value}
    if not changed:
        return before
    number = connection.scalars(select(sweeps.c.number).where(sweeps.c.id == sweep_id)).one()
    if (tags := changed.pop("tags", None)) is not None:
        sweep_names.replace_tags(connection, number, tags)
    if (archived := changed.pop("archived", None)) is not None:
        changed["archived_at"] = now() if archived else None
    if "webhook" in changed:
        changed |= {"webhook_tries": 0, "webhook_problem": "", "webhook_not_before": 0.0}
    if changed:
        connection.execute(update(sweeps).where(sweeps.c.number == number).values(changed))
    events.append(connection, [events.sweep_changed(number, sweep_id, "edited")])
    return get(connection, sweep_id)
