"""Curve file: measurements as CSV, one row each, written as they are made.

    seed,timestep,return_mean,return_history,updates,jacobians,seconds,compile_seconds,
    <diagnostics by name>

Numbers are written so that reading returns the same bits; a number that does not exist is nan.
"""

import csv
from collections.abc import Iterable
from typing import TextIO

from algorithms.measurement import Measurement

COLUMNS = (
    "seed", "timestep", "return_mean", "return_history", "updates", "jacobians", "seconds",
    "compile_seconds",
)  # fmt: skip


class CurveFile:
    """Writes the measurements of one training."""

    def __init__(self, file: TextIO) -> None:
        """Write to an open file, from its beginning on."""
        self._file = file
        self._rows = csv.writer(file, lineterminator="\n")
        self._diagnostics: list[str] | None = None

    def write(self, measurements: Iterable[Measurement]) -> None:
        """Add a row for each; on return, the rows survive the end of this process."""
        for m in measurements:
            if self._diagnostics is None:
                self._diagnostics = list(m.diagnostics)
                self._rows.writerow([*COLUMNS, *self._diagnostics])
            own = [getattr(m, name) for name in COLUMNS]
            self._rows.writerow([*own, *(m.diagnostics[name] for name in self._diagnostics)])
        self._file.flush()
