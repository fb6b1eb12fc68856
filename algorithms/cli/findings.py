"""Findings: a diagnosis as tables, no wider than 60 columns, and as CSV.

    seed,diagnostic,quantity,horizon,noise,value

Tables show the median over the seeds; a number that does not exist in a seed is left out.
"""

import csv
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, TextIO

import numpy as np
from rich.table import Table

if TYPE_CHECKING:
    from algorithms.diagnostics.finding import Finding

TITLES = {
    "smoothing": "Gradient of the smoothed return of H steps",
    "growth": "Norm of d s(t+H) / d s(t) along episodes",
    "kinks": "Share of steps",
    "critic": "Critic's gradient beside the rollout's, cut after H",
    "target": "Critic's gradient beside its own target",
    "loss": "Share of the gradient loss in 1 % of the rows",
}
"""Of each diagnostic, in the order of the tables."""
Medians = dict[tuple[str, str, int | None, float | None], float]


def write(file: TextIO, by_seed: "Mapping[int, Iterable[Finding]]") -> None:
    """Write every finding of every seed."""
    rows = csv.writer(file, lineterminator="\n")
    rows.writerow(["seed", "diagnostic", "quantity", "horizon", "noise", "value"])
    for seed, findings in by_seed.items():
        rows.writerows([seed, *finding] for finding in findings)


def tables(by_seed: "Mapping[int, Iterable[Finding]]") -> Iterator[tuple[str, Table]]:
    """The title and the table of each diagnostic."""
    found = medians(by_seed)
    for diagnostic, title in TITLES.items():
        own = {key: value for key, value in found.items() if key[0] == diagnostic}
        if own:
            has_horizon = any(horizon is not None for _, _, horizon, _ in own)
            yield title, by_horizon(own) if has_horizon else listed(own)


def medians(by_seed: "Mapping[int, Iterable[Finding]]") -> Medians:
    """The median over the seeds of each number, NaN where no seed has it."""
    values: dict[tuple[str, str, int | None, float | None], list[float]] = {}
    for findings in by_seed.values():
        for *name, value in findings:
            values.setdefault(tuple(name), []).append(value)  # type: ignore[arg-type]
    return {name: median(each) for name, each in values.items()}


def median(values: list[float]) -> float:
    """The median of the numbers that are not NaN; NaN if there are none."""
    numbers = [value for value in values if not np.isnan(value)]
    return float(np.median(numbers)) if numbers else float("nan")


def by_horizon(own: Medians) -> Table:
    """A row for each horizon and noise, a column for each quantity."""
    quantities = list(dict.fromkeys(quantity for _, quantity, _, _ in own))
    [diagnostic] = {diagnostic for diagnostic, _, _, _ in own}
    has_noise = any(noise is not None for _, _, _, noise in own)
    table = compact()
    for header in ["H", *(["noise"] if has_noise else []), *quantities]:
        table.add_column(header.replace("_", "\n"), justify="right")
    for horizon, noise in dict.fromkeys((horizon, noise) for _, _, horizon, noise in own):
        place = [str(horizon), *([f"{noise:g}"] if has_noise else [])]
        numbers = [own.get((diagnostic, name, horizon, noise), np.nan) for name in quantities]
        table.add_row(*place, *(f"{number:.3g}" for number in numbers))
    return table


def listed(own: Medians) -> Table:
    """A row for each quantity."""
    table = compact()
    table.add_column("")
    table.add_column("", justify="right")
    table.show_header = False
    for (_, quantity, _, _), value in own.items():
        table.add_row(quantity.replace("_", " "), f"{value:.3g}")
    return table


def compact() -> Table:
    """A table with one space between columns."""
    return Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
