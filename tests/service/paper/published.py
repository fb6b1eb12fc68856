"""The published evaluation, read from the files of results/ and nothing else."""

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

RESULTS = Path(__file__).parents[3] / "results"

Floats = NDArray[np.float64]
Cell = tuple[str, str, float, float]
"""Environment, algorithm, w1, w2: one curve of the evaluation."""
COLUMNS = ("timestep", "return_mean", "return_history", "jacobians", "seconds")


def lines(name: str) -> Iterator[dict[str, str]]:
    """Yield the lines of a CSV file by column."""
    with (RESULTS / name).open(encoding="utf-8", newline="") as file:
        yield from csv.DictReader(file)


def document(name: str) -> Any:
    """Return a JSON file."""
    return json.loads((RESULTS / name).read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Scale:
    """The normalised scale of a task."""

    random: float
    low: float
    high: float
    best: float

    @property
    def unit(self) -> float:
        return self.best - self.random


@cache
def scales() -> Mapping[str, Scale]:
    return {
        line["environment"]: Scale(
            *(float(line[name]) for name in ("random", "low", "high", "best"))
        )
        for line in lines("random-returns.csv")
    }


@cache
def runs() -> Mapping[Cell, Mapping[int, Mapping[str, str]]]:
    """The lines of scores.csv, by cell and seed."""
    found: dict[Cell, dict[int, Mapping[str, str]]] = {}
    for line in lines("scores.csv"):
        found.setdefault(cell_of(line["environment"], line["algorithm"], line), {})[
            int(line["seed"])
        ] = line
    return found


@cache
def measurements() -> Mapping[Cell, Mapping[int, Mapping[str, Floats]]]:
    """Columns [n] of all runs, by cell and seed."""
    rows: dict[Cell, dict[int, list[tuple[float, ...]]]] = {}
    for file in sorted((RESULTS / "measurements").glob("*/*.csv")):
        for line in lines(str(file.relative_to(RESULTS))):
            cell = cell_of(file.parent.name, file.stem, line)
            values = tuple(float(line[name]) for name in COLUMNS)
            rows.setdefault(cell, {}).setdefault(int(line["seed"]), []).append(values)
    return {
        cell: {
            seed: dict(zip(COLUMNS, np.array(values).T, strict=True))
            for seed, values in seeds.items()
        }
        for cell, seeds in rows.items()
    }


def cell_of(environment: str, algorithm: str, line: Mapping[str, str]) -> Cell:
    return environment, algorithm, float(line["w1"]), float(line["w2"])


def scores(cell: Cell, score: str) -> Floats:
    """Return the normalised scores of a cell's runs that reached their end [n], by seed."""
    scale = scales()[cell[0]]
    ended = [line for line in runs()[cell].values() if line["status"] == "succeeded"]
    raw = np.array([float(line[score]) for line in sorted(ended, key=lambda x: int(x["seed"]))])
    return (raw - scale.random) / scale.unit


def cell(environment: str, algorithm: str) -> Cell:
    """Return the only cell of an algorithm in a task."""
    [found] = [each for each in runs() if each[:2] == (environment, algorithm)]
    return found
