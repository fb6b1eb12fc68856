"""The runs of the evaluation, read from its files; analyses of them need no service."""

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from algorithms import catalogue
from service.analysis.curves import Floats
from service.paper.evaluation import row
from workers.messages.run_spec import Weights

Columns = Mapping[str, Floats]

READ = ("timestep", "return_mean", "jacobians", "seconds")
"""The columns of measurements that analyses use."""
NOTHING: Columns = {name: np.empty(0) for name in READ}
ENDED = "succeeded"
EARLY = ("failed", "diverged", "cancelled")


@dataclass(frozen=True)
class MeasuredRun:
    """A run with its measurements.

    Attributes:
        row: the name of its learner (`service.paper.evaluation.row`).
        baseline: that of the learner it extends; empty for none.
        timesteps: that were asked for.
        status: how it stands.
        processor: LLVM's name of the one it was trained on; seconds of two are not comparable.
        columns: of its measurements, each [n].
    """

    environment: str
    algorithm: str
    row: str
    baseline: str
    weights: Weights
    seed: int
    timesteps: int
    status: str
    processor: str
    columns: Columns


@dataclass(frozen=True)
class Scale:
    """Where the normalised scale of a task starts, and the length of its unit."""

    random: float
    unit: float


def read_runs(folder: Path) -> list[MeasuredRun]:
    """Read the runs of scores.csv with their measurements, in its order."""
    runs = []
    measured: dict[Path, dict[tuple[Weights, int], Columns]] = {}
    for line in lines(folder / "scores.csv"):
        config = json.loads(line["config"])
        name, extended = row(line["algorithm"], config), catalogue.baseline(line["algorithm"])
        weights, seed = Weights(float(line["w1"]), float(line["w2"])), int(line["seed"])
        file = measurements_file(folder, line["environment"], name)
        if file not in measured:
            measured[file] = _columns(file)
        runs.append(
            MeasuredRun(
                line["environment"],
                line["algorithm"],
                name,
                row(extended, config) if extended else "",
                weights,
                seed,
                int(line["timesteps"]),
                line["status"],
                line["processor"],
                measured[file].get((weights, seed), NOTHING),
            )
        )
    return runs


def read_scales(folder: Path) -> dict[str, Scale]:
    """Read the normalised scales of random-returns.csv, by task."""
    return {
        line["environment"]: Scale(
            float(line["random"]), float(line["best"]) - float(line["random"])
        )
        for line in lines(folder / "random-returns.csv")
    }


def measurements_file(folder: Path, environment: str, name: str) -> Path:
    """The file of a learner's measurements in a task."""
    return folder / "measurements" / environment / f"{name.replace(' ', '-')}.csv"


def _columns(file: Path) -> dict[tuple[Weights, int], Columns]:
    """Read the measurements of a file, by run; the file is missing while no run has begun."""
    if not file.exists():
        return {}
    rows: dict[tuple[Weights, int], list[list[float]]] = {}
    for line in lines(file):
        run = Weights(float(line["w1"]), float(line["w2"])), int(line["seed"])
        rows.setdefault(run, []).append([float(line[name]) for name in READ])
    return {run: dict(zip(READ, np.array(values).T, strict=True)) for run, values in rows.items()}


def lines(file: Path) -> Iterator[dict[str, str]]:
    """Yield the lines of a CSV file by the names of its columns."""
    with file.open(encoding="utf-8", newline="") as text:
        yield from csv.DictReader(text)
