"""Diagnoses as figures: a column a task, a row a quantity; of one task, beside each other.

Each line or bar is an entry, of the median over its diagnosed seeds. Both quantities of smoothing
are relative: the bias to the gradient of the smoothed return, the standard deviation to that of the
zeroth-order estimate (each a ratio of medians).
"""

import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator

from service.analysis.comparison import grouped
from service.analysis.diagnosis import FIGURES, DiagnosedCell, FigureName
from service.analysis.figures.figure_form import Form
from service.analysis.figures.picture import picture, printable
from service.analysis.figures.plot import (
    CAPTION_CHARACTERS_PER_INCH,
    LEGEND_COLUMN_INCHES,
    LEGEND_ROW_INCHES,
    Style,
    legend_of,
    styles_of_entries,
)
from service.model.request.entry import Entry

COLUMN_INCHES = 2.5
ROW_INCHES = 1.8
MIN_WIDTH_INCHES = 5.0
TEXT_INCHES = 1.3
TITLE_CHARACTERS_PER_INCH = 14
CAPTION_POINTS = 7.0
MOST_RELATIVE_BIAS = 2.0
"""Larger ones are drawn there: the gradient is then too small to be divided by."""
LEAST_PLACES = 3
"""Of bars, so that a single one is not as wide as its panel."""
LEAST_RELATIVE_STD = 1e-3
"""Smaller ones are drawn there, such as of a policy that is saturated."""
MARGIN = 1.2
"""Of the abscissa, beside the first and the last horizon."""
LIMITS: Mapping[FigureName, str] = {
    "smoothing": (
        f"Both are ratios of medians; a bias above {MOST_RELATIVE_BIAS:g} and a deviation below "
        f"{LEAST_RELATIVE_STD:g} are drawn there."
    )
}

Draw = Callable[[Axes, Sequence[DiagnosedCell], Mapping[str, Style]], None]


@dataclass(frozen=True)
class Panel:
    """A quantity of a figure, and what draws it for the cells of one task."""

    ordinate: str
    draw: Draw


def draw(
    name: FigureName,
    subject: str,
    cells: Sequence[DiagnosedCell],
    entries: Sequence[Entry],
    form: Form,
) -> bytes:
    """Return a figure as a file's bytes; `entries` are all of the request's, shown or not."""
    shown = [cell for cell in cells if cell.has(name)]
    return picture(lambda: _figure(name, subject, shown, entries), form)


def _figure(
    name: FigureName, subject: str, cells: Sequence[DiagnosedCell], entries: Sequence[Entry]
) -> Figure:
    tasks = grouped(cells, lambda cell: cell.environment)
    panels = _panels(name, cells)
    is_grid = len(tasks) > 1
    rows, columns = (len(panels), len(tasks)) if is_grid else _beside(len(panels))
    styles = styles_of_entries(entries, [cell.label for cell in cells])
    width = max(MIN_WIDTH_INCHES, COLUMN_INCHES * columns)
    legend_columns = max(1, min(len(styles), int(width / LEGEND_COLUMN_INCHES)))
    lines = textwrap.wrap(
        _caption(name, cells), int(width * CAPTION_CHARACTERS_PER_INCH / CAPTION_POINTS)
    )
    legend = LEGEND_ROW_INCHES * math.ceil(len(styles) / legend_columns)
    figure = Figure(figsize=(width, ROW_INCHES * rows + TEXT_INCHES + legend), layout="constrained")
    places = iter(figure.subplots(rows, columns, squeeze=False).flat)
    for panel in panels:
        for task, members in tasks.items():
            ax = next(places)
            panel.draw(ax, members, styles)
            ax.grid(visible=True)
            if not is_grid or task is next(iter(tasks)):
                ax.set_ylabel(panel.ordinate)
            if is_grid and panel is panels[0]:
                ax.set_title(printable(task))
            if is_grid and panel is not panels[-1]:
                ax.set_xlabel("")
    where = "" if is_grid else f" in {printable(next(iter(tasks)))}"
    subjects = textwrap.wrap(printable(subject), int(width * TITLE_CHARACTERS_PER_INCH))
    title = "\n".join([FIGURES[name].title + where, *subjects])
    legend_of(figure, title, {label: label for label in styles}, styles, legend_columns)
    figure.supxlabel("\n".join(lines), fontsize=CAPTION_POINTS)
    return figure


def _beside(panels: int) -> tuple[int, int]:
    """Rows and columns of the panels of one task."""
    columns = min(2, panels)
    return math.ceil(panels / columns), columns


def _caption(name: FigureName, cells: Sequence[DiagnosedCell]) -> str:
    counts = [len(cell.seeds) for cell in cells]
    least, most = min(counts), max(counts)
    n = f"n = {most}" if least == most else f"n = {least} to {most}"
    n = n.replace(" ", "\N{NO-BREAK SPACE}")
    of_runs = f"Medians over the n diagnosed runs (seeds) of an entry, {n}."
    return " ".join(filter(None, [FIGURES[name].definition, of_runs, LIMITS.get(name)]))


def _panels(name: FigureName, cells: Sequence[DiagnosedCell]) -> list[Panel]:
    match name:
        case "smoothing":
            noises = sorted({key[3] for cell in cells for key in cell.medians if key[3] and key[2]})
            return [
                *(Panel(f"relative bias, noise {noise:g}", _bias(noise)) for noise in noises),
                *(Panel(f"relative std, noise {noise:g}", _std(noise)) for noise in noises),
            ]
        case "growth":
            return [Panel("norm", _draw_growth)]
        case "critic":
            return [Panel(f"cosine, in the {part}", _cosine(part)) for part in ("action", "state")]
        case "loss":
            return [Panel(f"share, in the {part}", _share(part)) for part in ("action", "state")]


def _bias(noise: float) -> Draw:
    def draw(ax: Axes, cells: Sequence[DiagnosedCell], styles: Mapping[str, Style]) -> None:
        for cell in cells:
            rows = _by_horizon(cell, "smoothing", ("bias", "norm", "resolution"), noise)
            told = [
                (horizon, min(bias / norm, MOST_RELATIVE_BIAS), bias > resolution)
                for horizon, bias, norm, resolution in rows
                if norm > 0
            ]
            points = [(horizon, value) for horizon, value, _ in told]
            _draw_line(ax, points, styles[cell.label], [is_told for *_, is_told in told])
        ax.axhline(1.0, color="0.6", linewidth=0.8)
        _, top = ax.get_ylim()
        ax.set_ylim(-0.06, max(1.15, top))
        _end(ax, cells, "smoothing", "the samples find\nno gradient here")

    return draw


def _std(noise: float) -> Draw:
    def draw(ax: Axes, cells: Sequence[DiagnosedCell], styles: Mapping[str, Style]) -> None:
        for cell in cells:
            rows = _by_horizon(cell, "smoothing", ("exact_std", "zeroth_std"), noise)
            points = [
                (horizon, max(exact / zeroth, LEAST_RELATIVE_STD))
                for horizon, exact, zeroth in rows
                if exact > 0 and zeroth > 0
            ]
            _draw_line(ax, points, styles[cell.label])
        _log_ordinate(ax, 0.1)
        _end(ax, cells, "smoothing", "the exact gradient\ndoes not vary here")

    return draw


def _draw_growth(ax: Axes, cells: Sequence[DiagnosedCell], styles: Mapping[str, Style]) -> None:
    for cell in cells:
        style = styles[cell.label]
        rows = _by_horizon(cell, "growth", ("median_norm", "high_norm"))
        rows = [row for row in rows if min(row) > 0]
        _draw_line(ax, [(horizon, median) for horizon, median, _ in rows], style)
        horizon, median, high = ([row[k] for row in rows] for k in range(3))
        ax.fill_between(horizon, median, high, color=style["color"], alpha=0.2, linewidth=0)
    _log_ordinate(ax, 0.5)
    _end(ax, cells, "growth", "no episode is long enough")


def _cosine(part: str) -> Draw:
    def draw(ax: Axes, cells: Sequence[DiagnosedCell], styles: Mapping[str, Style]) -> None:
        for cell in cells:
            rows = _by_horizon(cell, "critic", (f"{part}_cosine",))
            _draw_line(ax, [(horizon, cosine) for horizon, cosine in rows], styles[cell.label])
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.set_ylim(-1.05, 1.05)
        _end(ax, cells, "critic", "no gradient\nhas a direction here")

    return draw


def _share(part: str) -> Draw:
    def draw(ax: Axes, cells: Sequence[DiagnosedCell], styles: Mapping[str, Style]) -> None:
        ax.set_ylim(0.0, 1.05)
        ax.set_xticks([])
        ax.set_xlim(-0.6, max(LEAST_PLACES, len(cells)) - 0.4)
        for place, cell in enumerate(cells):
            shares = [
                value
                for key, value in cell.medians.items()
                if key[:2] == ("loss", f"{part}_top_share")
            ]
            style = styles[cell.label]
            ax.bar(place, shares, 0.7, facecolor=(style["color"], 0.35), edgecolor=style["color"],
                   linestyle=style["linestyle"])  # fmt: skip

    return draw


def _by_horizon(
    cell: DiagnosedCell, diagnostic: str, quantities: Sequence[str], noise: float | None = None
) -> list[tuple[float, ...]]:
    """Each horizon with its quantities, where all of them are finite."""
    horizons = sorted({key[2] for key in cell.medians if key[0] == diagnostic and key[2]})
    rows = [
        (horizon, *(cell.medians.get((diagnostic, q, horizon, noise), np.nan) for q in quantities))
        for horizon in horizons
    ]
    return [row for row in rows if np.isfinite(row).all()]


def _draw_line(
    ax: Axes, points: Sequence[tuple[float, float]], style: Style, told: Sequence[bool] = ()
) -> None:
    """Draw a line with a mark at each point; hollow marks where it is not told from 0."""
    x, y = [horizon for horizon, _ in points], [value for _, value in points]
    ax.plot(x, y, linewidth=1.2, **style)
    for horizon, value, is_told in zip(x, y, told or [True] * len(x), strict=True):
        face = style["color"] if is_told else "white"
        ax.plot(horizon, value, "o", markersize=4, color=style["color"], markerfacecolor=face)


def _log_ordinate(ax: Axes, least: float) -> None:
    """A logarithmic ordinate from `least` or less to 2 or more, a line at 1, in plain digits."""
    ax.axhline(1.0, color="0.6", linewidth=0.8)
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    low, high = min(low, least), max(high, 2.0)
    ax.set_ylim(low, high)
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 200 * low else (1.0,)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_locator(NullLocator())


def _end(ax: Axes, cells: Sequence[DiagnosedCell], diagnostic: str, nothing: str) -> None:
    """Let the abscissa be the horizons, doubling; say where there is nothing to see."""
    horizons = sorted(
        {key[2] for cell in cells for key in cell.medians if key[0] == diagnostic and key[2]}
    )
    ax.set_xscale("log", base=2)
    ax.set_xlim(horizons[0] / MARGIN, horizons[-1] * MARGIN)
    ax.xaxis.set_major_locator(FixedLocator(horizons))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("H (steps)")
    if not any(np.size(line.get_xdata()) for line in ax.get_lines() if line.get_marker() == "o"):
        said = ax.text(0.5, 0.5, nothing, transform=ax.transAxes, color="0.4")
        said.set(ha="center", va="center", bbox={"facecolor": "white", "edgecolor": "none"})
