"""Every measurement of a run, as a table: JSON columns or CSV.

JSON has no NaN and no infinity: null stands for them, and `nonfinite` says which they were. CSV
writes them as `NaN`, `Infinity` and `-Infinity`. Other numbers are written with all their digits.
"""

import csv
import io
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from algorithms.measurement import Measurement
from service.api.schemas.score_table_answer import inert
from service.api.schemas.tabular import Tabular
from service.model.run import Run

Number = float | int
Columns = Mapping[str, Sequence[Number | None]]
OWN_COLUMNS = (
    "timestep", "return_mean", "return_history", "updates", "jacobians", "seconds",
    "compile_seconds",
)  # fmt: skip


SPEC_COLUMNS = ("run", "label", "algorithm", "environment", "w1", "w2", "config", "seed")
"""Columns of a sweep before those: the run that a measurement belongs to."""


class NonfiniteAnswer(BaseModel):
    """A value that is null in its column because it is not finite."""

    column: str
    timestep: int
    value: str = Field(description="`NaN`, `Infinity` or `-Infinity`.")


class MeasurementsAnswer(Tabular):
    """The table. Diagnostics that a measurement lacks are null too.

    `seconds` is processor time of training so far, acting and learning alone; `compile_seconds`
    that of compiling and loading kernels, null where an earlier version measured.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "run_id": "3f9a0c51b7de-17",
                    "columns": {
                        "timestep": [800, 1600],
                        "return_mean": [-1203.5, -980.25],
                        "return_history": [-1203.5, -1091.875],
                        "updates": [400, 800],
                        "jacobians": [25600, 51200],
                        "seconds": [0.31, 0.6],
                        "compile_seconds": [1.25, 1.25],
                        "critic_loss": [0.5, None],
                    },
                    "nonfinite": [{"column": "critic_loss", "timestep": 1600, "value": "NaN"}],
                }
            ]
        }
    )

    run_id: str
    columns: dict[str, list[float | int | None]]
    nonfinite: list[NonfiniteAnswer]

    def records(self) -> Iterator[dict[str, Any]]:
        """Yield a record a measurement, with the values that are not finite in their places."""
        rest = {(each.timestep, each.column): float(each.value) for each in self.nonfinite}
        for values in zip(*self.columns.values(), strict=True):
            row = dict(zip(self.columns, values, strict=True))
            yield {name: rest.get((row["timestep"], name), value) for name, value in row.items()}


def table(measurements: Sequence[Measurement]) -> Columns:
    """Return measurements column by column; None where one lacks a diagnostic."""
    columns: dict[str, list[Number | None]] = {
        name: [getattr(measurement, name) for measurement in measurements] for name in OWN_COLUMNS
    }
    diagnostics = dict.fromkeys(name for each in measurements for name in each.diagnostics)
    for name in diagnostics:
        columns[name] = [measurement.diagnostics.get(name) for measurement in measurements]
    return columns


def measurements_json(run_id: str, columns: Columns) -> bytes:
    """Return the JSON of a `MeasurementsAnswer`."""
    nonfinite = [
        {"column": name, "timestep": columns["timestep"][row], "value": nonfinite_text(value)}
        for name, values in columns.items()
        for row, value in enumerate(values)
        if value is not None and not math.isfinite(value)
    ]
    finite = {
        name: [value if value is not None and math.isfinite(value) else None for value in values]
        for name, values in columns.items()
    }
    document = {"run_id": run_id, "columns": finite, "nonfinite": nonfinite}
    return json.dumps(document, allow_nan=False, separators=(",", ":")).encode()


def sweep_heading(diagnostics: Sequence[str]) -> str:
    """Return the first line of the CSV of a sweep."""
    return _lines([(*SPEC_COLUMNS, *OWN_COLUMNS, *diagnostics)])


def sweep_lines(
    run: Run, label: str, measurements: Sequence[Measurement], diagnostics: Sequence[str]
) -> str:
    """Return a line of CSV for each measurement of a run, in front of it what run it is of."""
    config = json.dumps(dict(run.spec.config), sort_keys=True)
    spec = (run.id, inert(label), inert(run.spec.algorithm), inert(run.spec.environment),
            *run.spec.weights, inert(config), run.spec.seed)  # fmt: skip
    return _lines(
        (
            *spec,
            *(_text(getattr(each, name)) for name in OWN_COLUMNS),
            *(_text(each.diagnostics[n]) if n in each.diagnostics else "" for n in diagnostics),
        )
        for each in measurements
    )


def _lines(rows: Iterable[Sequence[object]]) -> str:
    file = io.StringIO()
    csv.writer(file).writerows(rows)
    return file.getvalue()


def measurements_csv(columns: Columns) -> str:
    """Return the table as CSV (RFC 4180)."""
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow("" if value is None else _text(value) for value in row)
    return file.getvalue()


def nonfinite_text(value: Number) -> str:
    """Name a number that is not finite."""
    if math.isnan(value):
        return "NaN"
    return "Infinity" if value > 0 else "-Infinity"


def _text(value: Number) -> str:
    return repr(value) if math.isfinite(value) else nonfinite_text(value)
