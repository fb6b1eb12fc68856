"""Runs with all their measurements, one after the other, from the CSV of a sweep as it arrives."""

import csv
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from service.api.schemas.measured.measurements_answer import SPEC_COLUMNS

Row = Mapping[str, str]


@dataclass(frozen=True)
class MeasuredRun:
    """A run and its measurements.

    columns  each float64 [n], in order of timestep: `timestep`, `return_mean`, `return_history`,
             `updates`, `jacobians`, `seconds`, `compile_seconds`, and the diagnostics that the run
             has; NaN where one is missing
    """

    id: str
    label: str
    algorithm: str
    environment: str
    w1: float
    w2: float
    config: Mapping[str, Any]
    seed: int
    columns: Mapping[str, NDArray[np.float64]]

    @property
    def settings(self) -> dict[str, Any]:
        """What the run trains, as plain values, with the settings that it states by their names."""
        names = ("label", "algorithm", "environment", "w1", "w2", "seed")
        return {"run": self.id, **{name: getattr(self, name) for name in names}, **self.config}

    @property
    def steps(self) -> list[int]:
        """The timesteps of the measurements."""
        return [int(step) for step in self.columns["timestep"]]

    @property
    def metrics(self) -> dict[str, NDArray[np.float64]]:
        """Every column but the timesteps."""
        return {name: column for name, column in self.columns.items() if name != "timestep"}


def measured_runs(lines: Iterable[str]) -> Iterator[MeasuredRun]:
    """Yield the runs of a sweep's CSV, whose lines of one run follow each other.

    Only one run is held at a time. Runs without a measurement are not in it.
    """
    for _, rows in groupby(csv.DictReader(lines), itemgetter("run")):
        yield measured_run(list(rows))


def measured_run(rows: list[dict[str, str]]) -> MeasuredRun:
    """Return the run of the lines of one run; there is at least one."""
    first = rows[0]
    names = [name for name in first if name not in SPEC_COLUMNS]
    columns = {name: np.array(list(map(partial(_number, name), rows))) for name in names}
    return MeasuredRun(
        id=first["run"],
        label=first["label"],
        algorithm=first["algorithm"],
        environment=first["environment"],
        w1=float(first["w1"]),
        w2=float(first["w2"]),
        config=json.loads(first["config"]),
        seed=int(first["seed"]),
        columns={
            name: column for name, column in columns.items() if any(row[name] for row in rows)
        },
    )


def _number(name: str, row: Row) -> float:
    return float(row[name] or "nan")
