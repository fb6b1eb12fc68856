"""Lines of curves: one look an entry, in whatever figure it is."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from service.analysis.comparison import Comparison, View, compare
from service.analysis.figures.palette import BLUE, colour
from service.analysis.figures.plot import draw_panel, styles_of
from service.model.request.entry import Entries
from tests.service.scored import run_curve
from workers.messages.random_return import RandomReturn

VIEW = View("return_mean", normalized=False, band="std", x="timesteps", max_points=500)


def compared(algorithms: list[dict[str, Any]], *, environment: str = "") -> Comparison:
    """A sweep on two tasks with a seed each, or what of it is in one of them."""
    request = {"algorithms": algorithms, "environments": ["MassPoint", "Pendulum"], "seeds": 1}
    entries = Entries(request)
    curves = [
        run_curve(entry.algorithm, task, 0, [1.0], entry=entry.place)
        for task, entry in entries.cells
    ]
    shown = [one for one in curves if environment in ("", one.spec.environment)]
    return compare(shown, entries, VIEW, dict[tuple[str, int], RandomReturn](), lambda _: 0.0)


def test_no_two_entries_share_colour_and_dash() -> None:
    """Also not those of another's algorithm that happens on the same colour."""
    other = next(name for name in map("algorithm-{}".format, range(60)) if colour(name) == BLUE)
    weights = [{"w1": k / 10} for k in range(1, 13)]
    styles = styles_of(
        compared([{"name": "ddpg"}, {"name": other}, {"name": "hybrid-ddpg", "weights": weights}])
    )
    assert len(styles) == 14
    assert len({(style["color"], style["linestyle"]) for style in styles.values()}) == 14


def test_an_entry_looks_alike_where_its_siblings_are_not_shown() -> None:
    algorithms = [
        {"name": "ddpg", "config": {"noise": 0.3}, "environments": ["MassPoint"]},
        {"name": "ddpg", "config": {"noise": 0.1}},
    ]
    everywhere = styles_of(compared(algorithms))
    on_pendulum = styles_of(compared(algorithms, environment="Pendulum"))
    assert list(everywhere) == ["ddpg noise=0.3", "ddpg noise=0.1"]
    assert on_pendulum == {"ddpg noise=0.1": everywhere["ddpg noise=0.1"]}
    assert on_pendulum["ddpg noise=0.1"]["linestyle"] != "solid"


def test_a_curve_of_one_measurement_is_a_point_with_its_band() -> None:
    comparison = compared([{"name": "ddpg"}], environment="Pendulum")
    axes = Figure().subplots()
    draw_panel(axes, comparison.panels[0], styles_of(comparison))
    assert [line.get_marker() for line in axes.lines] == ["o", "None"]
    assert np.asarray(axes.lines[0].get_xydata()).tolist() == [[800.0, 1.0]]
    assert len(axes.collections) == 2  # the band's two ends, and the area of a line
