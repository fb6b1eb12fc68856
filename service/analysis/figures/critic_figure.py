"""The paper's figure 2: the mass point's critic as it learns, beside the truth.

Above, the return curves and Q* as simulation measures it. Below, a row per learner: Q over position
and action after some epochs, the policy drawn on it, and the slope dQ/ds along a = 0. A row shows a
single run, the first by seed: a mean of critics would be nobody's critic.
"""

import textwrap
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

import physics
from algorithms.measurement import MEASURE_EVERY
from physics.tasks.mass_point import START
from service.analysis.comparison import ABSCISSA_TEXT, Comparison, LabelledCurve
from service.analysis.figures.figure_data import as_csv, number_text
from service.analysis.figures.figure_form import Form
from service.analysis.figures.picture import picture, printable
from service.analysis.figures.plot import caption, draw_panel, styles_of
from workers.checkpoints.checkpoint import find_epochs, find_snapshot
from workers.checkpoints.checkpoint_folder import EPOCHS, SURFACE_TASK
from workers.checkpoints.place import Place
from workers.policies.critic_surface import (
    ACTIONS,
    POSITIONS,
    FloatArray,
    Surface,
    best_surface,
    critic_surface,
    discount_of,
)

WIDTH_INCHES = 11.0
ROW_INCHES = 1.9
CAPTION_INCHES = 0.9
CAPTION_CHARACTERS = 210
VISITED = (POSITIONS >= START) & (POSITIONS <= 0.0)
SLOPE_COLOURS = ("#9ecae1", "#4292c6", "#08306b")  # later is darker
CONTOURS = 8
COLUMNS = ("entry", "seed", "quantity", "epoch", "s", "a", "value")
DEFINITION = (
    f"Below, the critic of each learner's first seed; an epoch is {MEASURE_EVERY} timesteps, black "
    "the policy's action. Off by: root mean square of Q - Q* and of their slopes in s, from s = "
    "-0.5 to 0, where episodes lead; Q* is the discounted return of the action a, then of full "
    "speed towards 0."
)


class Critic(NamedTuple):
    """A run's critic as of an epoch; None where it was not kept, or is not reached yet."""

    epoch: int
    surface: Surface | None


class LearnedCritics(NamedTuple):
    """The critics of a learner's first run, one for each column."""

    label: str
    seed: int
    critics: Sequence[Critic]
    truth: FloatArray
    """[p, k], Q* at the run's discount."""


def draw(title: str, rows: Sequence[Comparison], form: Form, checkpoints: Place) -> bytes:
    """Return the figure as a file's bytes, of the learners in the one row (return_mean).

    Raises DamagedError if what was learned cannot be read, UnavailableError if its place is
    unavailable.
    """
    [returns] = rows
    learners = [_learner(one, checkpoints) for panel in returns.panels for one in panel.curves]
    return picture(lambda: _figure(title, returns, learners), form)


def numbers(rows: Sequence[Comparison], checkpoints: Place) -> str:
    """Return the values Q(s, a) and the policies' actions as CSV; Q* has no epoch.

    Raises as `draw`.
    """
    [returns] = rows
    learners = [_learner(one, checkpoints) for panel in returns.panels for one in panel.curves]
    return as_csv(COLUMNS, (line for learner in learners for line in _lines(learner)))


def _lines(learner: LearnedCritics) -> Iterator[Sequence[object]]:
    told = (learner.label, learner.seed)
    yield from _of_surface((*told, "Q*", ""), learner.truth)
    for epoch, surface in learner.critics:
        if surface is not None:
            yield from _of_surface((*told, "Q", epoch), surface.value)
            for s, a in zip(POSITIONS, surface.policy, strict=True):
                yield *told, "policy", epoch, number_text(s), "", number_text(a)


def _of_surface(told: Sequence[object], values: FloatArray) -> Iterator[Sequence[object]]:
    for s, row in zip(POSITIONS, values, strict=True):
        for a, value in zip(ACTIONS, row, strict=True):
            yield *told, number_text(s), number_text(a), number_text(value)


def _learner(one: LabelledCurve, checkpoints: Place) -> LearnedCritics:
    """Read what the curve's first run has learned."""
    first = min(one.seeds, key=lambda seed: seed.seed)
    task, gamma = physics.make(SURFACE_TASK), discount_of(one.spec)
    found = find_epochs(checkpoints, first.run_id)
    *early, last = EPOCHS
    latest = find_snapshot(checkpoints, first.run_id)
    if last not in found and latest is not None:
        last = latest.timestep // MEASURE_EVERY
        found[last] = latest
    critics = [
        Critic(epoch, critic_surface(task, found[epoch], gamma) if epoch in found else None)
        for epoch in (*early, last)
    ]
    return LearnedCritics(one.label, first.seed, critics, best_surface(task, gamma))


def _figure(title: str, returns: Comparison, learners: Sequence[LearnedCritics]) -> Figure:
    height = ROW_INCHES * (len(learners) + 1) + CAPTION_INCHES
    figure = Figure(figsize=(WIDTH_INCHES, height), layout="constrained")
    grid = figure.add_gridspec(len(learners) + 1, len(EPOCHS) + 1)
    _draw_returns(figure.add_subplot(grid[0, : len(EPOCHS)]), returns)
    truth = learners[0].truth
    scale = Normalize(float(truth.min()), float(truth.max()))
    ax = figure.add_subplot(grid[0, -1])
    ax.set_title("Q*")
    figure.colorbar(_draw_surface(ax, truth, scale), ax=ax, extend="both")
    for row, learner in enumerate(learners, start=1):
        *surfaces, slopes = (figure.add_subplot(grid[row, k]) for k in range(len(EPOCHS) + 1))
        for ax, critic in zip(surfaces, learner.critics, strict=True):
            _draw_critic(ax, critic, learner.truth, scale)
        surfaces[0].set_ylabel(f"{printable(learner.label)}\nseed {learner.seed}\na (m/s)")
        _draw_slopes(slopes, learner)
    figure.suptitle(printable(title))
    said = textwrap.wrap(f"{caption([returns])} {DEFINITION}", CAPTION_CHARACTERS)
    figure.supxlabel("\n".join(said), fontsize=7)
    return figure


def _draw_returns(ax: Axes, returns: Comparison) -> None:
    styles = styles_of(returns)
    for panel in returns.panels:
        draw_panel(ax, panel, styles)
    for label, style in styles.items():
        ax.plot([], [], label=printable(label), **style)
    ax.legend(frameon=False, loc="lower right")
    ax.set(xlabel=ABSCISSA_TEXT[returns.view.x], ylabel=f"{returns.view.metric} (normalised)")


def _draw_critic(ax: Axes, critic: Critic, truth: FloatArray, scale: Normalize) -> None:
    ax.set_title(f"epoch {critic.epoch}")
    if critic.surface is None:
        ax.text(0.5, 0.5, "not kept, or not reached", ha="center", color="0.4")
        ax.set_axis_off()
        return
    value = critic.surface.value
    _draw_surface(ax, value, scale)
    ax.plot(POSITIONS, critic.surface.policy, color="black", linewidth=1.2)
    error, slope_error = _distance(value, truth), _distance(_slope(value), _slope(truth))
    ax.set_title(f"epoch {critic.epoch}: off by {error:.2g}, slope by {slope_error:.2g}")


def _draw_surface(ax: Axes, values: FloatArray, scale: Normalize) -> AxesImage:
    extent = (POSITIONS[0], POSITIONS[-1], ACTIONS[0], ACTIONS[-1])
    image = ax.imshow(
        values.T, origin="lower", extent=extent, aspect="auto", norm=scale, cmap="cividis"
    )
    levels = scale.inverse(np.linspace(0.0, 1.0, CONTOURS))
    ax.contour(
        POSITIONS, ACTIONS, values.T, levels, colors="white", linewidths=0.4, linestyles="solid"
    )
    ax.set_xlabel("s (m)")
    return image


def _draw_slopes(ax: Axes, learner: LearnedCritics) -> None:
    """The slope of each epoch's critic and of the truth, along a = 0."""
    middle = len(ACTIONS) // 2
    for critic, colour in zip(learner.critics, SLOPE_COLOURS, strict=True):
        if critic.surface is not None:
            slope = _slope(critic.surface.value)[:, middle]
            ax.plot(POSITIONS, slope, color=colour, label=f"epoch {critic.epoch}")
    ax.plot(POSITIONS, _slope(learner.truth)[:, middle], "--", color="black", label="Q*")
    ax.set(title="∂Q/∂s at a = 0", xlabel="s (m)")
    ax.legend(frameon=False, fontsize=6)
    ax.grid(color="0.9", linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)


def _slope(values: FloatArray) -> FloatArray:
    """The derivative of values [p, k] in s, by differences."""
    return np.asarray(np.gradient(values, POSITIONS, axis=0))


def _distance(values: FloatArray, others: FloatArray) -> float:
    """The root mean square of a difference [p, k], where episodes lead."""
    return float(np.sqrt(np.mean((values - others)[VISITED] ** 2)))
