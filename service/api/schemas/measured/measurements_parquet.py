"""Every measurement of a sweep as Parquet: the columns of its CSV, some runs at a time."""

import io
import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from algorithms.measurement import Measurement
from service.api.schemas.measured.measurements_answer import OWN_COLUMNS, SPEC_COLUMNS
from service.extras import required
from service.model.run import Run

pyarrow = required("pyarrow", "parquet")
parquet = required("pyarrow.parquet", "parquet")

Measured = Iterable[tuple[Run, str, Sequence[Measurement]]]
"""Runs with the names of their entries."""
REPEATED = ("run", "label", "algorithm", "environment", "config")
WHOLE = ("seed", "timestep", "updates", "jacobians")


class _Parts(io.RawIOBase):
    """Keeps what is written to it until it is taken."""

    def __init__(self) -> None:
        """Keep nothing yet."""
        super().__init__()
        self._kept: list[bytes] = []

    def writable(self) -> bool:
        """It is."""
        return True

    def write(self, part: Any) -> int:
        """Keep a part."""
        self._kept.append(bytes(part))
        return len(part)

    def take(self) -> bytes:
        """Return what was kept since the last time."""
        taken = b"".join(self._kept)
        self._kept.clear()
        return taken


def parquet_parts(groups: Iterable[Measured], diagnostics: Sequence[str]) -> Iterator[bytes]:
    """Yield the bytes of a file, a row group for each group of runs that measured anything."""
    schema = pyarrow.schema([(name, _type(name)) for name in _names(diagnostics)])
    parts = _Parts()
    with parquet.ParquetWriter(parts, schema, compression="zstd") as writer:
        for group in groups:
            rows = [row for one in group for row in _rows(*one)]
            if rows:
                writer.write_table(pyarrow.Table.from_pylist(rows, schema))
            yield parts.take()
    yield parts.take()


def _names(diagnostics: Sequence[str]) -> tuple[str, ...]:
    return (*SPEC_COLUMNS, *OWN_COLUMNS, *diagnostics)


def _type(name: str) -> Any:
    if name in REPEATED:
        return pyarrow.dictionary(pyarrow.int32(), pyarrow.string())
    return pyarrow.int64() if name in WHOLE else pyarrow.float64()


def _rows(run: Run, label: str, measurements: Sequence[Measurement]) -> Iterator[dict[str, Any]]:
    config = json.dumps(dict(run.spec.config), sort_keys=True)
    spec = (run.id, label, run.spec.algorithm, run.spec.environment, *run.spec.weights, config,
            run.spec.seed)  # fmt: skip
    told = dict(zip(SPEC_COLUMNS, spec, strict=True))
    for each in measurements:
        own = {name: getattr(each, name) for name in OWN_COLUMNS}
        yield {**told, **own, **each.diagnostics}
