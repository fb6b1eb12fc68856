"""The look of a figure of curves: what is chosen for a paper, apart from the curves themselves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from service.analysis.comparison import Comparison, Panel

FontFamily = Literal["sans-serif", "serif", "monospace"]
Limits = tuple[float | None, float | None]
"""Where an axis ends; None where the data decide."""

COLUMN_INCHES: Mapping[int, float] = {1: 3.25, 2: 6.75}
"""The width of a figure that takes so many of a paper's two columns."""


@dataclass(frozen=True)
class Design:
    """The look of a figure.

    environments  the tasks shown, in this order; empty: all
    labels        the entries shown, in this order; empty: all
    names         what entries are called, by label, where it is something else
    colours       of entries, by label, where it is not their own
    smoothing     weight of the debiased exponential average, 0 for none
    is_robust     whether 2 % of the values at either end do not set the y axis
    is_aligned    whether all panels of a row have one y axis
    per_row       panels in a row, where one metric is shown; None: at most four
    width         inches; None: as the panels need
    """

    environments: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    colours: Mapping[str, str] = field(default_factory=dict)
    has_band: bool = True
    has_seeds: bool = False
    smoothing: float = 0.0
    is_log_x: bool = False
    is_log_y: bool = False
    x_limits: Limits = (None, None)
    y_limits: Limits = (None, None)
    is_robust: bool = False
    is_aligned: bool = False
    per_row: int | None = None
    width: float | None = None
    height: float | None = None
    font_size: float = 8.0
    font_family: FontFamily = "sans-serif"
    has_title: bool = True
    has_caption: bool = True
    has_legend: bool = True

    @property
    def settings(self) -> dict[str, object]:
        """Return what matplotlib is to be set to for it."""
        return {"font.size": self.font_size, "font.family": self.font_family}

    def name(self, label: str) -> str:
        """Return what an entry is called on the figure."""
        return self.names.get(label, label)

    def chosen(self, comparison: Comparison) -> Comparison:
        """Return those panels and curves that are shown, in their order."""
        panels = {panel.environment: panel for panel in comparison.panels}
        shown = _in_order(list(panels), self.environments)
        return replace(comparison, panels=tuple(self._panel(panels[each]) for each in shown))

    def _panel(self, panel: Panel) -> Panel:
        curves = {one.label: one for one in panel.curves}
        return replace(
            panel, curves=tuple(curves[label] for label in _in_order(list(curves), self.labels))
        )


def _in_order(present: Sequence[str], asked: Sequence[str]) -> list[str]:
    """Return those of the asked that are present, in the order asked; all if none are asked."""
    return [each for each in asked if each in present] if asked else list(present)
