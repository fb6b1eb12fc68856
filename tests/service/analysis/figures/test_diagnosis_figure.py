"""Figures of diagnoses: what is drawn where, and what is said where there is nothing."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from algorithms.diagnostics.medians import medians
from service.analysis.diagnosis import FIGURES, DiagnosedCell, FigureName
from service.analysis.figures import diagnosis_figure
from service.model.request.entry import Entries, Entry
from tests.service.found import HORIZONS, findings

EVERYONE: Sequence[Entry] = Entries(
    {"algorithms": [{"name": "ddpg"}, {"name": "gd"}], "environments": ["A", "B"], "seeds": 2}
).all


def cell(environment: str = "A", label: str = "ddpg", **changes: float) -> DiagnosedCell:
    """A cell of findings in which quantities are replaced."""
    found = medians([findings(has_critic=label != "gd")])
    for name in found:
        if name[1] in changes:
            found[name] = changes[name[1]]
    return DiagnosedCell(label, label, environment, (0, 1), found)


def axes_of(name: FigureName, *cells: DiagnosedCell) -> list[Axes]:
    shown = [each for each in cells if each.has(name)]
    return list(diagnosis_figure._figure(name, "a sweep", shown, EVERYONE).axes)


def marks(ax: Axes) -> list[tuple[float, float, bool]]:
    """Horizon and value of each mark, and whether it is filled."""
    drawn = [line for line in ax.get_lines() if line.get_marker() == "o"]
    return [(x_of(line), y_of(line), line.get_markerfacecolor() != "white") for line in drawn]


def x_of(line: Line2D) -> float:
    return float(np.ravel(line.get_xdata())[0])


def y_of(line: Line2D) -> float:
    return float(np.ravel(line.get_ydata())[0])


def said(ax: Axes) -> str:
    return " ".join(text.get_text() for text in ax.texts)


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_the_same_bytes_each_time(name: FigureName) -> None:
    cells = [cell("A"), cell("A", "gd"), cell("B")]
    first, second = (
        diagnosis_figure.draw(name, "a sweep", cells, EVERYONE, "png") for _ in range(2)
    )
    assert first.startswith(b"\x89PNG")
    assert first == second


@pytest.mark.parametrize(("name", "panels"), [("smoothing", 4), ("growth", 1), ("critic", 2)])
def test_a_column_a_task_a_row_a_quantity(name: FigureName, panels: int) -> None:
    axes = axes_of(name, cell("A"), cell("B"))
    assert len(axes) == 2 * panels
    assert [ax.get_title() for ax in axes[:2]] == ["A", "B"]
    assert len(axes_of(name, cell("A"))) == panels


def test_the_bias_is_relative_and_hollow_where_it_is_not_told_from_0() -> None:
    assert marks(axes_of("smoothing", cell())[0]) == [(h, 0.25, True) for h in HORIZONS]
    unsure = marks(axes_of("smoothing", cell(bias=0.01, resolution=0.02))[0])
    assert not any(filled for *_, filled in unsure)


def test_the_standard_deviation_is_that_of_the_exact_over_the_other_estimate() -> None:
    assert marks(axes_of("smoothing", cell())[2]) == [(h, 0.25, True) for h in HORIZONS]


def test_a_number_beyond_float64_is_left_out() -> None:
    assert marks(axes_of("smoothing", cell(exact_std=math.inf))[2]) == []
    [growth] = axes_of("growth", cell(high_norm=math.nan))
    assert "long enough" in said(growth)


def test_what_has_no_number_is_said() -> None:
    bias, _, deviation, _ = axes_of("smoothing", cell(norm=0.0, exact_std=0.0))
    assert "find\nno gradient" in said(bias)
    assert "does not vary" in said(deviation)
    critic = axes_of("critic", cell(action_cosine=math.nan))
    assert "direction" in said(critic[0])
    assert said(critic[1]) == ""


def test_a_critic_s_figures_leave_out_who_has_none() -> None:
    [figure] = {ax.figure for ax in axes_of("loss", cell(), cell(label="gd"))}
    assert figure is not None
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["ddpg"]


def test_bars_are_the_shares() -> None:
    action, _ = axes_of("loss", cell(action_top_share=0.75))
    assert [bar.get_height() for bar in action.patches] == [0.75]  # type: ignore[attr-defined]


def test_the_abscissa_has_the_horizons() -> None:
    [growth] = axes_of("growth", cell())
    assert [int(tick) for tick in growth.get_xticks()] == list(HORIZONS)
    assert all("$" not in label.get_text() for label in growth.get_yticklabels())
