"""The paper's figure 4: every curve as far as DDPG's go.

Planning an episode takes up to ten times their timesteps; drawn completely, it would compress the
curves of learners into a corner. The final result of planning is in table 1.
"""

from collections.abc import Sequence
from dataclasses import replace

from service.analysis.comparison import Comparison, LabelledCurve, Panel
from service.analysis.curves import Curve
from service.analysis.figures import plot
from service.analysis.figures.figure_form import Form

BASELINE = "ddpg"


def draw(title: str, rows: Sequence[Comparison], form: Form) -> bytes:
    """Return the figure as a file's bytes: a row per comparison, all of one sweep."""
    cut = [as_far_as_baseline(row) for row in rows]
    return plot.draw(f"{title}, as far as {BASELINE} goes", cut, form)


def numbers(rows: Sequence[Comparison]) -> str:
    """Return what the curves go through, as CSV."""
    return plot.numbers([as_far_as_baseline(row) for row in rows])


def as_far_as_baseline(comparison: Comparison) -> Comparison:
    """Leave out, in each panel that has the baseline, what lies beyond its last point."""
    return replace(comparison, panels=tuple(_cut(panel) for panel in comparison.panels))


def _cut(panel: Panel) -> Panel:
    ends = [one.curve.x[-1] for one in panel.curves if _is_baseline(one) and len(one.curve.x)]
    if not ends:
        return panel
    end = max(ends)
    curves = (replace(one, curve=_up_to(one.curve, end)) for one in panel.curves)
    return replace(panel, curves=tuple(curves))


def _is_baseline(one: LabelledCurve) -> bool:
    return one.spec.algorithm == BASELINE


def _up_to(curve: Curve, end: float) -> Curve:
    kept = curve.x <= end
    return Curve(
        curve.x[kept],
        curve.mean[kept],
        curve.low[kept],
        curve.high[kept],
        curve.n[kept],
        curve.values[:, kept],
        curve.is_interpolated,
    )
