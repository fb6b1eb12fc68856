"""Figure 4 ends where the baseline does."""

from service.analysis.comparison import Comparison, View, compare
from service.analysis.figures.learning_figure import as_far_as_baseline
from tests.service.scored import ByAlgorithm, run_curve
from workers.messages.random_return import RandomReturn

VIEW = View("return_mean", normalized=False, band="std", x="timesteps", max_points=500)


def compared(**lengths: int) -> Comparison:
    """Two seeds of each algorithm on Pendulum, measured so often."""
    curves = [
        run_curve(algorithm, "Pendulum", seed, [float(k) for k in range(length)])
        for algorithm, length in lengths.items()
        for seed in (0, 1)
    ]
    return compare(
        curves, ByAlgorithm(curves), VIEW, dict[tuple[str, int], RandomReturn](), lambda _: 0.0
    )


def ends(comparison: Comparison) -> dict[str, float]:
    [panel] = comparison.panels
    return {one.label: one.curve.x[-1] for one in panel.curves}


def test_curves_end_where_the_baseline_does() -> None:
    whole = compared(ddpg=4, mpc=40, gd=2)
    assert ends(as_far_as_baseline(whole)) == {"ddpg": 3200.0, "mpc": 3200.0, "gd": 1600.0}
    [panel] = as_far_as_baseline(whole).panels
    mpc = panel.curves[1].curve
    assert mpc.values.shape == (2, 4)
    assert mpc.mean.tolist() == [0.0, 1.0, 2.0, 3.0]


def test_where_the_baseline_is_not_there_nothing_is_left_out() -> None:
    assert ends(as_far_as_baseline(compared(mpc=40))) == {"mpc": 32_000.0}
