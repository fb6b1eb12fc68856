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
"""Environment, learner, w1, w2: one curve of the evaluation."""
LEARNED = "sac with learned temperature"
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
        found.setdefault(cell_of(line), {})[int(line["seed"])] = line
    return found


def cell_of(line: Mapping[str, str]) -> Cell:
    """Return the cell of a line that has its algorithm and settings."""
    is_learned = json.loads(line["config"]).get("temperature") == "learned"
    learner = LEARNED if is_learned else line["algorithm"]
    return line["environment"], learner, float(line["w1"]), float(line["w2"])


@cache
def measurements() -> Mapping[Cell, Mapping[int, Mapping[str, Floats]]]:
    """Columns [n] of all runs, by cell and seed."""
    names = {learner.replace(" ", "-"): learner for _, learner, *_ in runs()}
    rows: dict[Cell, dict[int, list[tuple[float, ...]]]] = {}
    for file in sorted((RESULTS / "measurements").glob("*/*.csv")):
        for line in lines(str(file.relative_to(RESULTS))):
            place = file.parent.name, names[file.stem]
            cell = (*place, float(line["w1"]), float(line["w2"]))
            values = tuple(float(line[name]) for name in COLUMNS)
            rows.setdefault(cell, {}).setdefault(int(line["seed"]), []).append(values)
    return {
        cell: {
            seed: dict(zip(COLUMNS, np.array(values).T, strict=True))
            for seed, values in seeds.items()
        }
        for cell, seeds in rows.items()
    }


def ended(cell: Cell) -> list[int]:
    """Return the seeds of a cell's runs that reached their end."""
    return sorted(seed for seed, line in runs()[cell].items() if line["status"] == "succeeded")


def scores(cell: Cell, score: str) -> Floats:
    """Return the normalised scores of a cell's runs that reached their end [n], by seed."""
    scale = scales()[cell[0]]
    raw = np.array([float(runs()[cell][seed][score]) for seed in ended(cell)])
    return (raw - scale.random) / scale.unit


def cell(environment: str, label: str) -> Cell:
    """Return the only cell of a learner, by its label in a sweep, in a task."""
    [found] = [each for each in runs() if each[:2] == (environment, label)]
    return found
