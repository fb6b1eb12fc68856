"""The numbers that a figure is drawn from, as CSV (RFC 4180): a line a point, in full precision."""

import csv
import io
from collections.abc import Sequence

import numpy as np

from service.analysis.comparison import Comparison
from service.analysis.figures.design import Design

COLUMNS = ("metric", "environment", "entry", "name", "x", "mean", "low", "high", "n")


def figure_data(rows: Sequence[Comparison], design: Design) -> str:
    """Return the data of a figure; empty where a number is not defined."""
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(COLUMNS)
    for row in rows:
        chosen = design.chosen(row)
        for panel in chosen.panels:
            for one in panel.curves:
                told = (row.view.metric, panel.environment, one.label, design.name(one.label))
                curve = one.curve
                for *numbers, n in zip(
                    curve.x, curve.mean, curve.low, curve.high, curve.n, strict=True
                ):
                    writer.writerow([*told, *map(_text, numbers), n])
    return file.getvalue()


def _text(number: float) -> str:
    return repr(float(number)) if np.isfinite(number) else ""
