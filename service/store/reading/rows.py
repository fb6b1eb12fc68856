"""Rows as the nouns of the model: a column goes to the field of its name."""

from dataclasses import fields
from functools import cache
from typing import Any, TypeVar, cast

from sqlalchemy import Row

Noun = TypeVar("Noun")


def noun_of(kind: type[Noun], row: Row[Any], **derived: Any) -> Noun:
    """Return a dataclass filled from a row.

    `derived` gives the fields that have no column of their name, or replaces it. Raises
    AttributeError for a field that has neither.
    """
    names = [name for name in _fields(cast(Any, kind)) if name not in derived]
    return kind(**{name: getattr(row, name) for name in names}, **derived)


@cache
def _fields(kind: Any) -> tuple[str, ...]:
    """The names of a dataclass's fields; a large sweep has thousands of rows."""
    return tuple(field.name for field in fields(kind))
