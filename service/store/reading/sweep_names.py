"""The names that sweeps are found by: their tags, algorithms and environments."""

from collections.abc import Collection, Iterable
from typing import Literal

from sqlalchemy import ColumnElement, Connection, delete, exists, func, insert, select

from service.store.tables import is_there, sweep_names, sweeps

Kind = Literal["tag", "algorithm", "environment"]


def add(connection: Connection, sweep_number: int, kind: Kind, names: Iterable[str]) -> None:
    """Give a sweep names of a kind, after those that it has; each once."""
    of_kind = (sweep_names.c.sweep_number == sweep_number) & (sweep_names.c.kind == kind)
    known = set(connection.scalars(select(sweep_names.c.name).where(of_kind)))
    rows = [
        {"sweep_number": sweep_number, "kind": kind, "name": name, "place": place}
        for place, name in enumerate(
            (name for name in dict.fromkeys(names) if name not in known), start=len(known)
        )
    ]
    if rows:
        connection.execute(insert(sweep_names), rows)


def replace_tags(connection: Connection, sweep_number: int, tags: Iterable[str]) -> None:
    """Give a sweep these tags and no others."""
    own = (sweep_names.c.sweep_number == sweep_number) & (sweep_names.c.kind == "tag")
    connection.execute(delete(sweep_names).where(own))
    add(connection, sweep_number, "tag", tags)


def has(kind: Kind, name: str) -> ColumnElement[bool]:
    """Return the condition that a sweep has a name of that kind."""
    return exists().where(
        sweep_names.c.sweep_number == sweeps.c.number,
        sweep_names.c.kind == kind,
        sweep_names.c.name == name,
    )


def tags(connection: Connection, sweep_numbers: Collection[int]) -> dict[int, list[str]]:
    """Return the tags of sweeps, by number; sweeps without tags are left out."""
    query = (
        select(sweep_names.c.sweep_number, sweep_names.c.name)
        .where(sweep_names.c.sweep_number.in_(sweep_numbers), sweep_names.c.kind == "tag")
        .order_by(sweep_names.c.sweep_number, sweep_names.c.place)
    )
    found: dict[int, list[str]] = {}
    for number, name in connection.execute(query):
        found.setdefault(number, []).append(name)
    return found


def all_tags(connection: Connection) -> dict[str, int]:
    """Return every tag in use, with the number of sweeps that have it."""
    query = (
        select(sweep_names.c.name, func.count())
        .join(sweeps, sweeps.c.number == sweep_names.c.sweep_number)
        .where(sweep_names.c.kind == "tag", is_there)
        .group_by(sweep_names.c.name)
        .order_by(sweep_names.c.name)
    )
    return {name: count for name, count in connection.execute(query)}  # noqa: C416
