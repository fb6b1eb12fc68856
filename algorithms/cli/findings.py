"""Findings: a diagnosis as tables, no wider than 60 columns, and as CSV.

    seed,diagnostic,quantity,horizon,noise,value

Tables show the median over the seeds; a number that does not exist in a seed is left out.
"""

import csv
from collections.abc import Iterable, Iterator, Mapping
from typing import TextIO

import numpy as np
from rich.table import Table

from algorithms.diagnostics.finding import Finding
from algorithms.diagnostics.medians import Medians, medians

TITLES = {
    "smoothing": "Gradient of the smoothed return of H steps",
    "growth": "Norm of d s(t+H) / d s(t) along episodes",
    "kinks": "Share of steps",
    "critic": "Critic's gradient beside the rollout's, cut after H",
    "target": "Critic's gradient beside its own target",
    "loss": "Share of the gradient loss in 1 % of the rows",
}
"""The title of each diagnostic, in the order of the tables."""


def write(file: TextIO, by_seed: Mapping[int, Iterable[Finding]]) -> None:
    """Write every finding of every seed."""
    rows = csv.writer(file, lineterminator="\n")
    rows.writerow(["seed", "diagnostic", "quantity", "horizon", "noise", "value"])
    for seed, findings in by_seed.items():
        rows.writerows([seed, *finding] for finding in findings)


def tables(by_seed: Mapping[int, Iterable[Finding]]) -> Iterator[tuple[str, Table]]:
    """The title and the table of each diagnostic, of medians over the seeds."""
    return tables_of(medians(by_seed.values()))


def tables_of(found: Medians) -> Iterator[tuple[str, Table]]:
    """The title and the table of each diagnostic."""
    for diagnostic, title in TITLES.items():
        own = {key: value for key, value in found.items() if key[0] == diagnostic}
        if own:
            has_horizon = any(horizon is not None for _, _, horizon, _ in own)
            yield title, by_horizon(own) if has_horizon else listed(own)


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
