"""Diagnostics of a measurement as bytes: little-endian float64, one after the other.

Exact whatever the value, a tenth of the rows of a table with one diagnostic a row, and a column
of one diagnostic is read without looking at the others. The names stand once, in
`diagnostic_sets`.
"""

import json
import struct
from collections.abc import Mapping, Sequence

import numpy as np
from sqlalchemy import ColumnElement, Connection, LargeBinary, func, insert, select

from service.store.tables import diagnostic_sets, measurements

FLOAT64 = np.dtype("<f8")


def pack(values: Mapping[str, float]) -> bytes:
    """Write the values in their order."""
    return struct.pack(f"<{len(values)}d", *values.values())


def unpack(names: Sequence[str], packed: bytes) -> dict[str, float]:
    """Read what `pack` wrote."""
    return dict(zip(names, np.frombuffer(packed, FLOAT64).tolist(), strict=True))


def value_at(place: int) -> ColumnElement[bytes]:
    """Return, as SQL, the bytes of the diagnostic at that place of its set."""
    size = FLOAT64.itemsize
    return func.substr(measurements.c.diagnostics, size * place + 1, size, type_=LargeBinary)


def set_number(connection: Connection, names: Sequence[str]) -> int:
    """Return the number of the set with these names in this order, new if need be."""
    text = json.dumps(list(names))
    known = connection.execute(
        select(diagnostic_sets.c.number).where(diagnostic_sets.c.names == text)
    ).scalar_one_or_none()
    if known is not None:
        return int(known)
    added = insert(diagnostic_sets).values(names=text).returning(diagnostic_sets.c.number)
    return int(connection.execute(added).scalar_one())


def sets(connection: Connection) -> dict[int, list[str]]:
    """Return the names of every set by its number."""
    rows = connection.execute(select(diagnostic_sets.c.number, diagnostic_sets.c.names))
    return {number: json.loads(names) for number, names in rows}
