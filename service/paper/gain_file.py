"""gains.csv: a line for each hybrid, task and cost (service.paper.differences)."""

import csv
from collections.abc import Iterable
from pathlib import Path

from service.paper.differences import Gain

COLUMNS = (
    *("environment", "algorithm", "w1", "w2", "cost", "n", "wins", "mean", "low", "high"),
    *("failed", "p", "holm_p", "bonferroni_low", "bonferroni_high"),
)


def write_gains(file: Path, gains: Iterable[Gain]) -> None:
    """Write the file."""
    with file.open("w", encoding="utf-8", newline="") as output:
        writer = csv.writer(output, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(map(_line, gains))


def _line(gain: Gain) -> tuple[object, ...]:
    place = (gain.environment, gain.algorithm, *gain.weights)
    mean = _decimals(gain.mean.value, gain.mean.low, gain.mean.high)
    p = (f"{gain.p:.3g}", f"{gain.corrected_p:.3g}")
    simultaneous = _decimals(gain.simultaneous.low, gain.simultaneous.high)
    return (*place, gain.cost, gain.n, gain.wins, *mean, gain.failed, *p, *simultaneous)


def _decimals(*values: float) -> tuple[str, ...]:
    return tuple(f"{value:.5f}" for value in values)
