"""Rows as the nouns of the model: a column goes to the field of its name."""

from dataclasses import fields
from typing import Any, TypeVar

from sqlalchemy import Row

Noun = TypeVar("Noun")


def noun_of(kind: type[Noun], row: Row[Any], **derived: Any) -> Noun:
    """Return a dataclass filled from a row.

    What is derived stands for fields that have no column of their name, or another one. Raises
    AttributeError for a field that has neither.
    """
    names = [field.name for field in fields(kind) if field.name not in derived]  # type: ignore[arg-type]
    return kind(**{name: getattr(row, name) for name in names}, **derived)
