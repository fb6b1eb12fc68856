"""Diagnostics of a measurement as bytes: little-endian float64, one after the other.

Exact whatever the value, a tenth of the rows of a table with one diagnostic a row, and a column
of one diagnostic is read without looking at the others. The names stand once, in
`diagnostic_sets`.
"""

import json
import struct
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, insert, select

from service.store.tables import diagnostic_sets

FLOAT64 = np.dtype("<f8")


def pack(values: Mapping[str, float]) -> bytes:
    """Write the values in their order."""
    return struct.pack(f"<{len(values)}d", *values.values())


def unpack(names: Sequence[str], packed: bytes) -> dict[str, float]:
    """Read what `pack` wrote."""
    return dict(zip(names, np.frombuffer(packed, FLOAT64).tolist(), strict=True))


def column(names: Sequence[str], name: str, packed: Sequence[bytes]) -> NDArray[np.float64]:
    """Return one diagnostic of many measurements of one set, float64 [n]."""
    table = np.frombuffer(b"".join(packed), FLOAT64).reshape(len(packed), len(names))
    return table[:, names.index(name)].astype(np.float64)


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
