"""The paper's figure 4 for any sweep, as a picture file.

Two rows, return_mean above return_history; a column per environment; a line and its band per
entry. What it shows (statistic, band, n, normalisation) is printed on it. The same data give
the same bytes, so a picture can be compared and cached.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from service.analysis.comparison import (
    ABSCISSA_TEXT,
    BAND_TEXT,
    Comparison,
    LabelledCurve,
    Panel,
    definition,
    grouped,
)
from service.analysis.curves import Floats
from service.analysis.figures.design import Design
from service.analysis.figures.figure_data import figure_data
from service.analysis.figures.figure_form import Form
from service.analysis.figures.palette import colour, dash, shades
from service.analysis.figures.picture import picture, printable
from service.analysis.figures.y_scale import YScale, robust_range, y_scale
from service.model.request.entry import Entry, setting_text
from service.model.run_curve import RETURNS

Style = Mapping[str, Any]

COLUMN_INCHES = 2.8
MIN_WIDTH_INCHES = 6.4
ROW_INCHES = 2.3
PER_ROW = 4  # panels of a single metric
CAPTION_INCHES = 0.6
LEGEND_COLUMN_INCHES = 1.8
LEGEND_ROW_INCHES = 0.18
HANDLE_LENGTHS = 4.0  # of the font's size: a whole pattern of dashes and dots
CAPTION_CHARACTERS_PER_INCH = 133.0  # at a size of one point
FAINT = 0.35
REFERENCE = "0.45"


class Place(NamedTuple):
    """Where a panel stands in the grid, and of which row of comparisons it is."""

    comparison: Comparison
    panel: Panel
    row: int
    column: int


def draw(title: str, rows: Sequence[Comparison], form: Form, design: Design | None = None) -> bytes:
    """Return the figure as a file's bytes: a row per comparison, all of one sweep."""
    design = design or Design()
    return picture(lambda: _figure(title, rows, design), form, design.settings)


def numbers(rows: Sequence[Comparison]) -> str:
    """Return what the curves go through, as CSV."""
    return figure_data(rows, Design())


def caption(rows: Sequence[Comparison], design: Design | None = None) -> str:
    """Say what the figure shows, with the number of runs in its curves."""
    design = design or Design()
    counts = [int(one.curve.n.max(initial=0)) for row in rows for one in _all_curves(row)]
    least, most = min(counts, default=0), max(counts, default=0)
    n = f"n = {most}" if least == most else f"n = {least} to {most}"
    said = definition(rows)
    if not design.has_band:
        said = said.replace(f" and {BAND_TEXT[rows[0].view.band]}", "", 1)
    if design.smoothing:
        said = said.replace(
            "no smoothing",
            f"bold lines are smoothed (debiased exponential average, weight {design.smoothing:g})",
        )
    return f"{said} {n}."


def _figure(title: str, asked: Sequence[Comparison], design: Design) -> Figure:
    rows = [design.chosen(row) for row in asked]
    places, columns = _places(rows, design)
    styles = styles_of(asked[0], design)
    width = design.width or max(MIN_WIDTH_INCHES, COLUMN_INCHES * columns)
    across = max(1, min(len(styles), int(width / LEGEND_COLUMN_INCHES)))
    down = 1 + places[-1].row if places else 1
    figure = Figure(figsize=(width, design.height or _height(down, styles, across, design)))
    figure.set_layout_engine("constrained")
    axes = figure.subplots(down, columns, sharex="col" if len(rows) > 1 else False, squeeze=False)
    for ax in axes.flat[len(places) :] if len(rows) == 1 else ():
        ax.set_axis_off()
    for place in places:
        _draw_place(axes[place.row, place.column], place, design, styles)
    for row in range(down) if design.is_aligned else ():
        _align([axes[place.row, place.column] for place in places if place.row == row])
    _label(axes, places)
    if design.has_legend and styles:
        names = {label: design.name(label) for label in styles}
        legend_of(figure, printable(title) if design.has_title else None, names, styles, across)
    elif design.has_title:
        figure.suptitle(printable(title))
    if design.has_caption:
        size = design.font_size - 1
        characters = int(width * CAPTION_CHARACTERS_PER_INCH / size)
        lines = textwrap.wrap(caption(rows, design), characters)
        figure.supxlabel("\n".join(lines), fontsize=size)
    return figure


def _places(rows: Sequence[Comparison], design: Design) -> tuple[list[Place], int]:
    """Lay out the panels: a row per comparison; a single one is wrapped as the design says."""
    panels = max(1, len(rows[0].panels))
    columns = min(panels, design.per_row or PER_ROW) if len(rows) == 1 else panels
    places = [
        Place(row, panel, number + index // columns, index % columns)
        for number, row in enumerate(rows)
        for index, panel in enumerate(row.panels)
    ]
    return places, columns


def _height(down: int, styles: Mapping[str, Style], across: int, design: Design) -> float:
    legend = LEGEND_ROW_INCHES * (1 + math.ceil(len(styles) / across)) * design.has_legend
    return ROW_INCHES * down + CAPTION_INCHES * design.has_caption + legend


def _draw_place(ax: Axes, place: Place, design: Design, styles: Mapping[str, Style]) -> None:
    draw_panel(ax, place.panel, styles, design, references_of(place.comparison, place.panel))
    if design.is_log_x:
        ax.set_xscale("log")
    else:
        ax.xaxis.set_major_formatter(EngFormatter(sep=""))  # 20k
    ax.set_xlim(*design.x_limits)
    ax.set_title(printable(place.panel.environment))


def _align(axes: Sequence[Axes]) -> None:
    """Give panels the y axis that holds what each of them shows."""
    lows, highs = zip(*(ax.get_ylim() for ax in axes), strict=True)
    for ax in axes:
        ax.set_ylim(min(lows), max(highs))


def _label(axes: NDArray[Any], places: Sequence[Place]) -> None:
    """Name the axes at the left and the bottom of the grid, and the tasks at its top."""
    below = {(place.row, place.column) for place in places}
    for comparison, _, row, column in places:
        ax, view = axes[row, column], comparison.view
        if column == 0:
            scale = " (normalised)" if view.normalized else " (raw)" * (view.metric in RETURNS)
            ax.set_ylabel(f"{view.metric}{scale}")
        if (row + 1, column) not in below:
            ax.set_xlabel(ABSCISSA_TEXT[view.x])
        if row > 0 and comparison is not places[0].comparison:
            ax.set_title("")


def references_of(comparison: Comparison, panel: Panel) -> dict[str, float]:
    """Return where the random policy and the largest reward lie, as far as that is known."""
    view, random = comparison.view, panel.random_return
    if view.metric not in RETURNS or random is None:
        return {}
    return {"random": 0.0, "maximum": 1.0} if view.normalized else {"random": random.mean}


def draw_panel(
    ax: Axes,
    panel: Panel,
    styles: Mapping[str, Style],
    design: Design | None = None,
    references: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Draw the curves of an environment, each in the style of its label, and lines to compare."""
    design = design or Design()
    for name, value in references.items():
        ax.axhline(value, color=REFERENCE, linestyle=(0, (3, 3)), linewidth=0.6, zorder=1)
        ax.annotate(
            name, (1, value), xycoords=ax.get_yaxis_transform(), ha="right", va="bottom",
            fontsize="small", color=REFERENCE,
        )  # fmt: skip
    values = np.append(_line_values(panel, design), list(references.values()))
    scale = y_scale(values, is_log=design.is_log_y)
    for one in panel.curves:
        _draw_curve(ax, one, styles[one.label], design, scale)
    if not any(one.curve.n.any() for one in panel.curves):
        ax.text(0.5, 0.5, "nothing to show yet", ha="center", transform=ax.transAxes, color="0.4")
    if scale.kind == "asinh":
        ax.set_yscale("asinh", linear_width=scale.linear_within)
    else:
        ax.set_yscale(scale.kind)
    if design.is_robust and len(values):
        ax.set_ylim(*robust_range(values))
    ax.set_ylim(*design.y_limits)
    ax.grid(visible=True)


def _draw_curve(ax: Axes, one: LabelledCurve, style: Style, design: Design, scale: YScale) -> None:
    curve, colour = one.curve, style["color"]
    low, high = np.maximum(curve.low, scale.floor), np.maximum(curve.high, scale.floor)
    alone = np.isfinite(curve.mean)
    if alone.sum() == 1:  # a line of one point is invisible
        ax.plot(curve.x[alone], curve.mean[alone], "o", markersize=4, color=colour)
        if design.has_band:
            ax.vlines(curve.x[alone], low[alone], high[alone], colour, alpha=0.4)
    for seed in one.seeds if design.has_seeds else ():
        ax.plot(curve.x, seed.values, linewidth=0.5, alpha=FAINT, color=colour)
    if design.smoothing:
        ax.plot(curve.x, curve.mean, linewidth=0.6, alpha=FAINT, color=colour)
    ax.plot(curve.x, scale.smooth(curve.mean, design.smoothing), **style)
    if design.has_band:
        ax.fill_between(curve.x, low, high, color=colour, alpha=0.2, linewidth=0)


def _line_values(panel: Panel, design: Design) -> Floats:
    """Return every finite value that a line of a panel goes through, [values]."""
    lines = [one.curve.mean for one in panel.curves]
    if design.has_seeds:
        lines += [seed.values for one in panel.curves for seed in one.seeds]
    values = np.concatenate(lines) if lines else np.empty(0)
    return values[np.isfinite(values)]


def styles_of(comparison: Comparison, design: Design | None = None) -> dict[str, Style]:
    """Return the line of each label shown: a shade and a dash of its algorithm's.

    Entries that are not shown have theirs too, so that a curve looks alike in every figure.
    """
    styles = styles_of_entries(comparison.entries, [entry.label for entry in comparison.entries])
    design = design or Design()
    present = list(dict.fromkeys(one.label for one in _all_curves(design.chosen(comparison))))
    shown = [label for label in design.labels if label in present] or present
    return {
        label: {**styles[label], "color": design.colours.get(label, styles[label]["color"])}
        for label in shown
    }


def styles_of_entries(entries: Sequence[Entry], shown: Sequence[str]) -> dict[str, Style]:
    """Return the line of each label shown, of the entries of a request."""
    styles: dict[str, Style] = {}
    for base, siblings in grouped(entries, lambda one: colour(one.algorithm)).items():
        ordered = [entry.label for entry in by_value(siblings)]
        tints = dict(zip(ordered, shades(base, len(siblings)), strict=True))
        for place, entry in enumerate(siblings):
            styles[entry.label] = {"color": tints[entry.label], "linestyle": dash(place)}
    return {label: styles[label] for label in dict.fromkeys(shown)}


def legend_of(
    figure: Figure,
    title: str | None,
    names: Mapping[str, str],
    styles: Mapping[str, Style],
    columns: int,
) -> None:
    """Put the title, of one line or several, and the names of the lines above the panels."""
    legend = figure.legend(
        title=title,
        handles=[
            Line2D([], [], label=printable(names[label]), **styles[label]) for label in styles
        ],
        loc="outside upper center",
        ncols=columns,
        handlelength=HANDLE_LENGTHS,
    )
    legend.get_title().set_multialignment("center")


def by_value(entries: Sequence[Entry]) -> Sequence[Entry]:
    """Order entries by the one number in which they differ; else leave them as they are."""
    names = dict.fromkeys(name for entry in entries for name in entry.stated)
    varied = [
        name for name in names if len({setting_text(e.stated.get(name)) for e in entries}) > 1
    ]
    if len(varied) != 1:
        return entries
    values = [entry.stated.get(varied[0]) for entry in entries]
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return entries
    return sorted(entries, key=lambda entry: float(entry.stated[varied[0]]))


def _all_curves(comparison: Comparison) -> list[LabelledCurve]:
    return [one for panel in comparison.panels for one in panel.curves]
