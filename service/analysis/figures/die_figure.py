"""The paper's figure 3: the die on its way to the target, thrown as the best runs learned to.

A row per learner: its best run by return_history, of those that reached their end. A column per
start: the first ones that the task draws, so that none is picked for what it shows.
"""

import textwrap
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

import physics
from physics.drawing import box
from physics.environment import Environment, FloatArray
from physics.tasks.rolling_die import DT, TARGET_X, TARGET_Y
from service.analysis.comparison import Comparison, LabelledCurve
from service.analysis.figures.figure_data import as_csv, number_text
from service.analysis.figures.figure_form import Form
from service.analysis.figures.picture import picture, printable
from service.model.run import RunStatus
from workers.checkpoints.checkpoint import find_snapshot
from workers.checkpoints.place import Place
from workers.policies.episode import Episode, play

DIE_TASK = "RollingDie"
STARTS = (0, 1, 2)
ONE_BOUNCE_SECONDS = 0.1  # contacts that follow one another so fast
COLUMN_INCHES = 3.6
ROW_INCHES = 2.2
CAPTION_INCHES = 0.9
CAPTION_CHARACTERS = 195
SIDE = 1.0  # m
COLUMNS = ("entry", "seed", "start", "step", "x", "y", "theta", "bounce_begins")
RED, LIGHT_RED, CYAN, BLUE = "#b2182b", "#f4a58288", "#00a6c8", "#2166ac"


class Thrown(NamedTuple):
    """An episode, and the states [b, 6] after the step in which each bounce begins."""

    episode: Episode
    bounces: FloatArray


class LearnedThrows(NamedTuple):
    """A learner's best run: of which seed, what it reached, its episodes from `STARTS`.

    No seed while no run has reached its end, no episodes where its policy is not there.
    """

    label: str
    seed: int | None
    history: float
    thrown: Sequence[Thrown]


def draw(title: str, rows: Sequence[Comparison], form: Form, checkpoints: Place) -> bytes:
    """Return the figure as a file's bytes, of the learners in the one row (raw return_history).

    Raises DamagedError if what was learned cannot be read, UnavailableError if its place is
    unavailable.
    """
    [histories] = rows
    learners = [_best(one, checkpoints) for panel in histories.panels for one in panel.curves]
    return picture(lambda: _figure(title, learners), form)


def numbers(rows: Sequence[Comparison], checkpoints: Place) -> str:
    """Return the way of the die as CSV, a line a step. Raises as `draw`."""
    [histories] = rows
    learners = [_best(one, checkpoints) for panel in histories.panels for one in panel.curves]
    return as_csv(COLUMNS, (line for learner in learners for line in _lines(learner)))


def _lines(learner: LearnedThrows) -> Iterator[Sequence[object]]:
    for start, (episode, begun) in zip(STARTS, learner.thrown, strict=False):
        hit = {tuple(state) for state in begun.tolist()}
        for step, state in enumerate(episode.states.tolist()):
            x, y, theta = map(number_text, state[:3])
            yield learner.label, learner.seed, start, step, x, y, theta, tuple(state) in hit


def bounces(touching: Sequence[int]) -> list[int]:
    """The first step of each bounce, of the steps in which the die touches something."""
    apart = ONE_BOUNCE_SECONDS / DT
    return [*touching[:1], *(step for before, step in pairwise(touching) if step - before > apart)]


def _best(one: LabelledCurve, checkpoints: Place) -> LearnedThrows:
    """Play what the best run of a curve has learned."""
    finished = [seed for seed in one.seeds if seed.status is RunStatus.SUCCEEDED]
    if not finished:
        return LearnedThrows(one.label, None, -np.inf, [])
    best = max(finished, key=lambda seed: (_last_finite(seed.values), -seed.seed))
    task, snapshot = physics.make(DIE_TASK), find_snapshot(checkpoints, best.run_id)
    episodes = (
        []
        if snapshot is None
        else [play(task, snapshot.policies(), start) for start in task.initial_states(STARTS)]
    )
    thrown = [_thrown(task, episode) for episode in episodes]
    return LearnedThrows(one.label, best.seed, _last_finite(best.values), thrown)


def _thrown(task: Environment, episode: Episode) -> Thrown:
    contacts = task.contact_impulses(episode.states[:-1], episode.actions)
    begun = bounces([step for step, impulses in enumerate(contacts) if len(impulses)])
    return Thrown(episode, episode.states[[step + 1 for step in begun]])


def _last_finite(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite[-1]) if len(finite) else -np.inf


def _figure(title: str, learners: Sequence[LearnedThrows]) -> Figure:
    size = COLUMN_INCHES * len(STARTS), ROW_INCHES * len(learners) + CAPTION_INCHES
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(learners), len(STARTS), sharex=True, sharey=True, squeeze=False)
    for row, learner in zip(axes, learners, strict=True):
        best = "no run has ended" if learner.seed is None else f"best run: seed {learner.seed}"
        row[0].set_ylabel(f"{printable(learner.label)}\n{best}\ny (m)")
        for ax in row:
            ax.set_aspect("equal")
            ax.spines[["top", "right"]].set_visible(False)
        if not learner.thrown:
            row[0].text(0.5, 0.5, "nothing learned yet", ha="center", transform=row[0].transAxes)
        for ax, start, thrown in zip(row, STARTS, learner.thrown, strict=False):
            count = len(thrown.bounces)
            ax.set_title(
                f"start {start}: {count} bounce{'' if count == 1 else 's'}, "
                f"return {thrown.episode.rewards.sum():.4g}"
            )
            _draw_episode(ax, thrown)
    for ax in axes[-1]:
        ax.set_xlabel("x (m)")
    figure.suptitle(printable(title))
    figure.supxlabel("\n".join(textwrap.wrap(_caption(learners), CAPTION_CHARACTERS)), fontsize=7)
    return figure


def _draw_episode(ax: Axes, thrown: Thrown) -> None:
    ax.axhline(0.0, color="0.4", linewidth=0.8)
    ax.add_patch(Polygon(box((TARGET_X, TARGET_Y), SIDE, SIDE, "target").points, color=BLUE))
    states = thrown.episode.states
    for state in (*thrown.bounces, states[-1]):
        ax.add_patch(Polygon(_corners(state), facecolor=LIGHT_RED, edgecolor=RED, linewidth=0.6))
    ax.add_patch(Polygon(_corners(states[0]), color=RED))
    ax.plot(states[:, 0], states[:, 1], color=CYAN, linestyle="dashed", linewidth=1.2)
    ax.margins(0.05)


def _corners(state: FloatArray) -> Sequence[tuple[float, float]]:
    x, y, theta = (float(number) for number in state[:3])
    return box((x, y), SIDE, SIDE, "body", theta).points


def _caption(learners: Sequence[LearnedThrows]) -> str:
    best = ", ".join(
        f"{learner.label} {learner.history:.4g}"
        for learner in learners
        if np.isfinite(learner.history)
    )
    return (
        "Of each learner's runs that reached their end, the one of the highest return_history "
        f"(mean of its latest 100 return_mean, raw: {best or 'none yet'}), acting without noise "
        f"from the starts that the task draws for seeds {', '.join(map(str, STARTS))}. Red: the "
        "start; light red: each bounce and the end; dashed: the die's centre; blue: the target. "
        f"Contacts within {ONE_BOUNCE_SECONDS:g} s are one bounce."
    )
