"""Trials of learners on seeds that no evaluation uses: area under the normalised curve, per seed.

    python -m service.paper.search.trials --algorithm hybrid-td3 --weights 1,0.1 --seeds 100-107

Each cell (task, timesteps, algorithm, weights, settings, seeds) is trained once, at one core, and
added to `results/trials.csv`, which keeps failures, too; a cell in the file is not trained
again. Then the gain over the baseline at equal seeds is printed, with 1.96 standard errors.
"""

import argparse
import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from typer import echo

import algorithms
from algorithms import catalogue
from algorithms.early_end import DivergedError, FailedRunsError
from algorithms.presets import completed
from service.model.environment import best_return

ROOT = Path(__file__).parents[3]
TRIALS, RANDOM = ROOT / "results/trials.csv", ROOT / "results/random-returns.csv"
TIMESTEPS = {
    "Pendulum": 20_000,
    "MountainCar": 40_000,
    "Acrobot": 40_000,
    "CartPole": 30_000,
    "RollingDie": 40_000,
    "CartPoleSwingUp": 80_000,
    "HalfCheetah": 40_000,
}


class Cell(NamedTuple):
    """A trained cell: every field as text, as in a line of the file."""

    environment: str
    timesteps: str
    algorithm: str
    w1: str
    w2: str
    config: str
    seeds: str


def kept() -> dict[Cell, NDArray[np.float64]]:
    """The areas of each cell of the file, by seed."""
    if not TRIALS.exists():
        return {}
    with TRIALS.open(newline="") as file:
        rows = list(csv.reader(file))[1:]
    return {Cell(*row[:-1]): np.array(row[-1].split(), np.float64) for row in rows}


def keep(cell: Cell, areas: NDArray[np.float64]) -> None:
    """Add a line."""
    is_new = not TRIALS.exists()
    with TRIALS.open("a", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if is_new:
            writer.writerow([*Cell._fields, "areas"])
        writer.writerow([*cell, " ".join(f"{area:.4f}" for area in areas)])


def trained(cell: Cell) -> NDArray[np.float64]:
    """The area of each seed; NaN for one that ended early."""
    first, last = map(int, cell.seeds.split("-"))
    seeds = range(first, last + 1)
    weights = float(cell.w1), float(cell.w2)
    returns: dict[int, list[float]] = {seed: [] for seed in seeds}
    try:
        for m in algorithms.train(
            cell.algorithm, cell.environment, seeds, weights, int(cell.timesteps),
            json.loads(cell.config),
        ):  # fmt: skip
            returns[m.seed].append(m.return_mean)
    except (DivergedError, FailedRunsError) as error:
        echo(f"  {error}")
    count = max(map(len, returns.values()))
    with RANDOM.open(newline="") as file:
        [random] = [
            float(row["random"])
            for row in csv.DictReader(file)
            if row["environment"] == cell.environment
        ]
    whole = best_return(cell.environment) - random
    return np.array([
        (np.mean(curve) - random) / whole if len(curve) == count else np.nan
        for curve in returns.values()
    ])  # fmt: skip


def areas_of(cell: Cell) -> NDArray[np.float64]:
    """Return the areas from the file, or train the cell and add it."""
    known = kept()
    if cell not in known:
        keep(cell, trained(cell))
        known = kept()
    return known[cell]


def cells(options: argparse.Namespace) -> Iterator[tuple[Cell, Cell]]:
    """Each cell asked for, with its baseline's."""
    given: dict[str, Any] = json.loads(options.config)
    for environment in options.tasks.split(","):
        timesteps = str(options.timesteps or TIMESTEPS[environment])
        for pair in options.weights.split(";"):
            w1, w2 = pair.split(",")
            config = completed(options.algorithm, environment, given)
            base = catalogue.baseline(options.algorithm) or options.algorithm
            plain = json.dumps(completed(base, environment, {}), sort_keys=True)
            own = json.dumps(config, sort_keys=True)
            yield (
                Cell(environment, timesteps, options.algorithm, w1, w2, own, options.seeds),
                Cell(environment, timesteps, base, "0", "0", plain, options.seeds),
            )


def main() -> None:
    """Train the missing cells; print all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--algorithm", required=True)
    parser.add_argument("--weights", default="0,0", help='"w1,w2" or "w1,w2;w1,w2"')
    parser.add_argument("--tasks", default=",".join(TIMESTEPS))
    parser.add_argument("--timesteps", type=int, default=0)
    parser.add_argument("--seeds", default="100-107")
    parser.add_argument("--config", default="{}", help="settings over the preset's, as JSON")
    for cell, base in cells(parser.parse_args()):
        own, plain = areas_of(cell), areas_of(base)
        gain = own - plain
        error = 1.96 * np.nanstd(gain, ddof=1) / np.sqrt(np.isfinite(gain).sum())
        echo(
            f"{cell.environment:16} {cell.algorithm:20} ({cell.w1}, {cell.w2}) {cell.seeds}  "
            f"{np.nanmean(plain):.3f} -> {np.nanmean(own):.3f}  "
            f"{np.nanmean(gain):+.3f} +- {error:.3f}  {(gain > 0).sum()} of {len(gain)}",
        )


if __name__ == "__main__":
    main()
