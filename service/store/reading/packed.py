"""Floats of a measurement as bytes: little-endian float64, one after the other.

First those that every measurement has (OWN), then its diagnostics, whose names stand once, in
`diagnostic_sets`. Exact whatever the value; and the points of a run are read as one value, without
an object of Python for each.
"""

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import (
    ColumnElement,
    Connection,
    LargeBinary,
    Text,
    cast,
    func,
    insert,
    literal,
    select,
)

from algorithms.measurement import Measurement
from service.store.tables import diagnostic_sets

FLOAT64 = np.dtype("<f8")
OWN = ("return_mean", "return_history", "seconds", "compile_seconds")


def pack(measurement: Measurement) -> bytes:
    """Write its floats."""
    common = (getattr(measurement, name) for name in OWN)
    values = (*common, *measurement.diagnostics.values())
    return struct.pack(f"<{len(values)}d", *values)


def own(packed: bytes) -> dict[str, float]:
    """Read the floats that every measurement has, by name."""
    return dict(zip(OWN, struct.unpack_from(f"<{len(OWN)}d", packed), strict=True))


def unpack(names: Sequence[str], packed: bytes) -> dict[str, Any]:
    """Read what `pack` wrote: OWN by name, and `diagnostics`, which have these names."""
    others = np.frombuffer(packed, FLOAT64)[len(OWN) :].tolist()
    return {**own(packed), "diagnostics": dict(zip(names, others, strict=True))}


def joined(column: ColumnElement[bytes]) -> ColumnElement[bytes]:
    """Return, as SQL, the floats of a group's measurements, one after the other in their order."""
    return cast(func.string_agg(column, literal(b"", LargeBinary)), LargeBinary)


def listed(column: ColumnElement[int]) -> ColumnElement[str]:
    """Return, as SQL, the integers of a group's measurements, with commas, in their order."""
    return func.string_agg(cast(column, Text), literal(","))


def floats(found: bytes) -> NDArray[np.float64]:
    """Read what `joined` found, [n]."""
    return np.frombuffer(found, FLOAT64)


def integers(found: str) -> NDArray[np.int64]:
    """Read what `listed` found, [n]."""
    return np.fromstring(found, np.int64, sep=",")


@dataclass(frozen=True)
class Where:
    """Where the floats of one name are in those that `joined` found of a run.

    rows    the measurements that have one, [n]
    at      the places of these floats, [n]
    """

    rows: NDArray[np.int64]
    at: NDArray[np.int64]


class Layout:
    """The places of floats by name, in runs whose measurements may have different sets."""

    def __init__(self, sets: Mapping[int, Sequence[str]]) -> None:
        """Of these sets of diagnostics, by number."""
        self._names = {number: (*OWN, *names) for number, names in sets.items()}
        self._known: dict[tuple[str, str], Where] = {}

    def where(self, name: str, sets: str) -> Where:
        """Return where a name is, by the sets of a run's measurements, as `listed` found them."""
        if (name, sets) not in self._known:
            of_each = [self._names[number] for number in integers(sets).tolist()]
            ends = np.cumsum([len(names) for names in of_each])
            starts = (end - len(names) for end, names in zip(ends, of_each, strict=True))
            found = [
                (row, start + names.index(name))
                for row, (start, names) in enumerate(zip(starts, of_each, strict=True))
                if name in names
            ]
            rows, at = np.array(found, np.int64).reshape(-1, 2).T
            self._known[name, sets] = Where(rows, at)
        return self._known[name, sets]


def set_number(connection: Connection, names: Sequence[str]) -> int:
    """Return the number of the set with these names in this order; add it if it is missing."""
    text = json.dumps(list(names))
    known = connection.execute(
        select(diagnostic_sets.c.number).where(diagnostic_sets.c.names == text)
    ).scalar_one_or_none()
    if known is not None:
        return int(known)
    added = insert(diagnostic_sets).values(names=text).returning(diagnostic_sets.c.number)
    return int(connection.execute(added).scalar_one())


def sets(connection: Connection) -> dict[int, list[str]]:
    """Return the names of every set of diagnostics by its number."""
    rows = connection.execute(select(diagnostic_sets.c.number, diagnostic_sets.c.names))
    return {number: json.loads(names) for number, names in rows}
