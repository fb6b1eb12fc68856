"""The paper's figure 4 for any sweep, as a picture file.

Two rows, return_mean above return_history; a column per environment; a line and its band per
entry. What it shows (statistic, band, n, normalisation) is printed on it. The same data give
the same bytes, so a picture can be compared and cached.
"""

import math
import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter

from service.analysis.comparison import ABSCISSA_TEXT, Comparison, LabelledCurve, Panel, definition
from service.analysis.figures.figure_form import Form
from service.analysis.figures.palette import colour, dash
from service.analysis.figures.picture import picture, printable
from service.model.entry import Entry

Style = Mapping[str, Any]

COLUMN_INCHES = 2.8
MIN_WIDTH_INCHES = 6.4
PANELS_INCHES = 5.2  # both rows and the caption
LEGEND_COLUMN_INCHES = 1.8
LEGEND_ROW_INCHES = 0.18
HANDLE_LENGTHS = 4.0  # of the font's size: a whole pattern of dashes and dots
CAPTION_CHARACTERS_PER_INCH = 19


def draw(title: str, rows: Sequence[Comparison], form: Form) -> bytes:
    """Return the figure as a file's bytes: a row per comparison, all of one sweep."""
    return picture(lambda: _figure(title, rows), form)


def caption(rows: Sequence[Comparison]) -> str:
    """Say what the figure shows, with the number of runs in its curves."""
    counts = [int(one.curve.n.max(initial=0)) for row in rows for one in _all_curves(row)]
    least, most = min(counts, default=0), max(counts, default=0)
    n = f"n = {most}" if least == most else f"n = {least} to {most}"
    return f"{definition(rows)} {n}."


def _figure(title: str, rows: Sequence[Comparison]) -> Figure:
    panels = max(1, len(rows[0].panels))
    width = max(MIN_WIDTH_INCHES, COLUMN_INCHES * panels)
    styles = styles_of(rows[0])
    legend_columns = max(1, min(len(styles), int(width / LEGEND_COLUMN_INCHES)))
    legend_rows = 1 + math.ceil(len(styles) / legend_columns)
    height = PANELS_INCHES + LEGEND_ROW_INCHES * legend_rows
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(len(rows), panels, sharex="col", squeeze=False)
    for axes_row, comparison in zip(axes, rows, strict=True):
        for ax, panel in zip(axes_row, comparison.panels, strict=False):
            draw_panel(ax, panel, styles)
        scale = "normalised" if comparison.view.normalized else "raw"
        axes_row[0].set_ylabel(f"{comparison.view.metric} ({scale})")
    for ax, panel in zip(axes[0], rows[0].panels, strict=False):
        ax.set_title(printable(panel.environment))
    for ax in axes[-1]:
        ax.set_xlabel(ABSCISSA_TEXT[rows[0].view.x])
        ax.xaxis.set_major_formatter(EngFormatter(sep=""))  # 20k
    legend_of(figure, printable(title), styles, legend_columns)
    lines = textwrap.wrap(caption(rows), int(width * CAPTION_CHARACTERS_PER_INCH))
    figure.supxlabel("\n".join(lines), fontsize=7)
    return figure


def draw_panel(ax: Axes, panel: Panel, styles: Mapping[str, Style]) -> None:
    """Draw the curves of an environment, each in the style of its label."""
    for one in panel.curves:
        style, curve = styles[one.label], one.curve
        alone = np.isfinite(curve.mean)
        if alone.sum() == 1:  # a line of one point is invisible
            ax.plot(curve.x[alone], curve.mean[alone], "o", markersize=4, color=style["color"])
            ax.vlines(
                curve.x[alone], curve.low[alone], curve.high[alone], style["color"], alpha=0.4
            )
        ax.plot(curve.x, curve.mean, linewidth=1.2, **style)
        ax.fill_between(
            curve.x, curve.low, curve.high, color=style["color"], alpha=0.2, linewidth=0
        )
    if not any(one.curve.n.any() for one in panel.curves):
        ax.text(0.5, 0.5, "nothing to show yet", ha="center", transform=ax.transAxes, color="0.4")
    plain_axes(ax)


def styles_of(comparison: Comparison) -> dict[str, Style]:
    """Return the line of each label shown: the algorithm's colour, a dash per further entry of it.

    Entries that are not shown have theirs too, so that a curve looks alike in every figure.
    """
    return styles_of_entries(comparison.entries, [one.label for one in _all_curves(comparison)])


def styles_of_entries(entries: Sequence[Entry], shown: Sequence[str]) -> dict[str, Style]:
    """Return the line of each label shown, of the entries of a request."""
    styles: dict[str, Style] = {}
    used: Counter[str] = Counter()
    for entry in entries:
        shade = colour(entry.algorithm)
        styles[entry.label] = {"color": shade, "linestyle": dash(used[shade])}
        used[shade] += 1
    return {label: styles[label] for label in dict.fromkeys(shown)}


def legend_of(figure: Figure, title: str, styles: Mapping[str, Style], columns: int) -> None:
    """Put the title, of one line or several, and the names of the lines above the panels."""
    legend = figure.legend(
        title=title,
        handles=[Line2D([], [], label=printable(label), **styles[label]) for label in styles],
        loc="outside upper center",
        ncols=columns,
        handlelength=HANDLE_LENGTHS,
        frameon=False,
    )
    legend.get_title().set_multialignment("center")


def plain_axes(ax: Axes) -> None:
    """Give a panel its grid, and only the left and the lower edge."""
    ax.grid(color="0.9", linewidth=0.6)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def _all_curves(comparison: Comparison) -> list[LabelledCurve]:
    return [one for panel in comparison.panels for one in panel.curves]
