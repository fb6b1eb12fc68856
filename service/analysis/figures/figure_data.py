"""The numbers that a figure is drawn from, as CSV (RFC 4180): a line a point, in full precision."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from service.analysis.comparison import Comparison
from service.analysis.figures.design import Design

COLUMNS = ("metric", "environment", "entry", "name", "x", "mean", "low", "high", "n")


def figure_data(rows: Sequence[Comparison], design: Design) -> str:
    """Return the data of a figure; empty where a number is not defined."""
    return as_csv(COLUMNS, (line for row in rows for line in _lines(row, design)))


def _lines(row: Comparison, design: Design) -> Iterator[Sequence[object]]:
    for panel in design.chosen(row).panels:
        for one in panel.curves:
            told = (row.view.metric, panel.environment, one.label, design.name(one.label))
            curve = one.curve
            for *numbers, n in zip(
                curve.x, curve.mean, curve.low, curve.high, curve.n, strict=True
            ):
                yield *told, *map(number_text, numbers), n


def as_csv(columns: Sequence[str], lines: Iterable[Sequence[object]]) -> str:
    """Return a table as CSV."""
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(columns)
    writer.writerows(lines)
    return file.getvalue()


def number_text(number: float) -> str:
    """Return a number with all its digits; empty where it is not finite."""
    return repr(float(number)) if np.isfinite(number) else ""
