"""Learners over many tasks: their interquartile means by timesteps and by time, and their ranks.

A row of the right panel is the legend of a learner's lines. Intervals of the lines, which would
hide one another, are with the figure's numbers.
"""

import textwrap
from collections import Counter
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from service.analysis.figures.figure_form import Form
from service.analysis.figures.palette import colour, dash
from service.analysis.figures.picture import picture, printable
from service.analysis.figures.plot import Style
from service.analysis.overview import Line, Standing

SIZE_INCHES = (7.2, 3.9)
WIDTHS = (1.0, 1.0, 0.75)
TICKS = (0.1, 0.3, 1.0, 3.0)
CAPTION_CHARACTERS = 150
CAPTION = (
    "Interquartile mean over the runs of all tasks of return_mean, normalised (0: uniform random "
    "actions, 1: the task's largest reward at every step). Timesteps are a share of those of "
    "ddpg's runs in the task, time is processor time of training in units of a run of ddpg there; "
    "what has ended keeps its last value. Rank: mean over tasks, 1 the best, by the mean of the "
    "curve over the timesteps, with its 95 % interval (stratified bootstrap). Early: runs that "
    "failed, diverged or were cancelled, which do not count."
)


def draw(standings: Sequence[Standing], form: Form) -> bytes:
    """Return the figure as a file's bytes."""
    return picture(lambda: _figure(standings), form)


def _figure(standings: Sequence[Standing]) -> Figure:
    figure = Figure(figsize=SIZE_INCHES, layout="constrained")
    by_timesteps, by_time, ranks = figure.subplots(1, 3, width_ratios=WIDTHS)
    styles = _styles(standings)
    for one, style in zip(standings, styles, strict=True):
        _draw_line(by_timesteps, one.by_timesteps, style)
        _draw_line(by_time, one.by_time, style)
    by_timesteps.set(xlabel="share of the timesteps", ylabel="interquartile mean, normalised")
    by_timesteps.set_xlim(0.0, 1.05)
    by_time.set(xlabel="processor time, in runs of ddpg", xscale="log")
    by_time.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
    by_time.set_xticks([], minor=True)
    by_time.sharey(by_timesteps)
    by_time.tick_params(labelleft=False)
    _draw_ranks(ranks, standings, styles)
    for ax in (by_timesteps, by_time, ranks):
        ax.grid(color="0.9", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)
    figure.supxlabel("\n".join(textwrap.wrap(CAPTION, CAPTION_CHARACTERS)), fontsize=6)
    return figure


def _styles(standings: Sequence[Standing]) -> list[Style]:
    """The line of each learner: its algorithm's colour, a dash for each further form of it."""
    used: Counter[str] = Counter()
    styles: list[Style] = []
    for one in standings:
        shade = colour(one.algorithm)
        styles.append({"color": shade, "linestyle": dash(used[shade])})
        used[shade] += 1
    return styles


def _draw_line(ax: Axes, line: Line, style: Style) -> None:
    marker = "o" if len(line.x) == 1 else None  # a line of one point is invisible
    ax.plot(line.x, line.mean, linewidth=1.2, marker=marker, markersize=3, **style)


def _draw_ranks(ax: Axes, standings: Sequence[Standing], styles: Sequence[Style]) -> None:
    """Draw the ranks, the best on top."""
    best_first = sorted(
        zip(standings, styles, strict=True), key=lambda each: each[0].rank.value, reverse=True
    )
    most = max(one.tasks for one in standings)
    for place, (one, style) in enumerate(best_first):
        ax.plot([one.rank.low, one.rank.high], [place, place], linewidth=2.0, **style)
        ax.plot(one.rank.value, place, "o", markersize=4, color=style["color"])
    ax.set_yticks(range(len(best_first)), [_label(one, most) for one, _ in best_first])
    ax.yaxis.tick_right()
    ax.spines["left"].set_visible(False)
    ax.set(xlabel="mean rank")


def _label(one: Standing, most: int) -> str:
    """The learner's name, with its tasks where others have more, and what is left out."""
    tasks = "" if one.tasks == most else f" ({one.tasks} of {most} tasks)"
    early = f" ({one.early} early)" if one.early else ""
    return printable(f"{one.label}{tasks}{early}")
