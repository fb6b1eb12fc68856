"""The estimated cost of a sweep: core-seconds by cell, from the costs of finished runs.

    core-seconds of a cell = rate * timesteps * seeds        wall time = sum over cells / workers

The rate (core-seconds a timestep) is that of the finished runs of the same algorithm and
environment, of those with the same settings where there are any. Without finished runs it is the
built-in figure of the algorithm's entry in the catalogue; where the entry has none of the task, the
cell's cost is not known. Runs trained together share their worker's time, so their seconds add up.

The cost of a run is its training alone (`Measurement.seconds`). A worker also evaluates it, which
adds some per cent, and for mpc once or twice the cost, and loads kernels, which takes seconds; the
first run of its kind on a machine compiles them, which takes a minute.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from algorithms import catalogue
from physics.parameter import name_of
from workers.messages.run_spec import RunSpec

Basis = Literal["same settings", "same algorithm and environment", "built-in figures", "unknown"]

BASIS_TEXT: Mapping[Basis, str] = {
    "same settings": "from finished runs with the same settings",
    "same algorithm and environment": "from finished runs with other settings",
    "built-in figures": "from built-in figures, good to a factor of two or so",
    "unknown": "are of unknown cost and left out: no run like theirs has finished",
}


@dataclass(frozen=True)
class PastCost:
    """What one finished run cost."""

    algorithm: str
    environment: str
    config: Mapping[str, Any]
    timesteps: int
    seconds: float


@dataclass(frozen=True)
class CellCost:
    """The estimated cost of all runs of one cell; NaN if unknown. It is based on `runs` runs."""

    core_seconds: float
    basis: Basis
    runs: int


def cell_costs(cells: Sequence[RunSpec], seeds: int, past: Sequence[PastCost]) -> list[CellCost]:
    """Return the cost of each cell, with so many seeds."""
    return [_cell_cost(cell, seeds, past) for cell in cells]


def total_core_seconds(costs: Sequence[CellCost]) -> float:
    """Return the sum of the known costs; NaN when none is."""
    known = [cost.core_seconds for cost in costs if math.isfinite(cost.core_seconds)]
    return sum(known) if known else math.nan


def wall_seconds(costs: Sequence[CellCost], workers: int) -> float:
    """Return the time that the known costs take a number of idle workers; NaN for none."""
    return total_core_seconds(costs) / workers if workers else math.nan


def about(seconds: float) -> str:
    """Return a rough duration: `about 4 min`; an empty text if it is unknown."""
    if not math.isfinite(seconds):
        return ""
    if seconds < 60:
        return f"about {max(1, round(seconds))} s"
    minutes = seconds / 60
    return f"about {minutes:.0f} min" if minutes < 60 else f"about {minutes / 60:.1f} h"


def explain(costs: Sequence[CellCost]) -> str:
    """Say what the estimate of a sweep is based on."""
    cells = Counter(cost.basis for cost in costs)
    parts = [f"{cells[basis]} of {len(costs)} cells {BASIS_TEXT[basis]}" for basis in cells]
    return "; ".join(parts) + "."


def _cell_cost(cell: RunSpec, seeds: int, past: Sequence[PastCost]) -> CellCost:
    pair = (cell.algorithm, cell.environment)
    alike = [cost for cost in past if (cost.algorithm, cost.environment) == pair]
    same = [cost for cost in alike if cost.config == cell.config]
    steps = cell.timesteps * seeds
    if same:
        return CellCost(_rate(same) * steps, "same settings", len(same))
    if alike:
        return CellCost(_rate(alike) * steps, "same algorithm and environment", len(alike))
    algorithm = catalogue.known(cell.algorithm)
    figure = algorithm.core_seconds.get(name_of(cell.environment)) if algorithm else None
    if figure is not None:
        return CellCost(figure / 1000 * steps, "built-in figures", 0)
    return CellCost(math.nan, "unknown", 0)


def _rate(costs: Sequence[PastCost]) -> float:
    """Core-seconds a timestep."""
    return sum(cost.seconds for cost in costs) / sum(cost.timesteps for cost in costs)
