"""What of a sweep a comparison shows, and in how many points."""

from dataclasses import replace

import pytest

from service.analysis import comparison
from service.analysis.comparison import Comparison, View, compare, definition
from tests.service.scored import ByAlgorithm, run_curve

VIEW = View("return_mean", normalized=False, band="std", x="timesteps", max_points=500)
RUNS = [
    run_curve(algorithm, environment, seed, [float(k) for k in range(40)])
    for environment in ("MassPoint", "Pendulum")
    for algorithm in ("ddpg", "sac", "gd")
    for seed in (0, 1)
]


def compared(view: View) -> Comparison:
    return compare(RUNS, ByAlgorithm(RUNS), view, {}, lambda _: 0.0)


def shown(view: View) -> list[tuple[str, str, int]]:
    """Environment, label and number of seeds of each curve."""
    return [
        (panel.environment, one.label, len(one.seeds))
        for panel in compared(view).panels
        for one in panel.curves
    ]


def test_all_runs_are_shown_unless_some_are_asked_for() -> None:
    assert len(shown(VIEW)) == 6
    assert shown(replace(VIEW, algorithms=("sac", "ddpg"), environment="Pendulum")) == [
        ("Pendulum", "ddpg", 2),
        ("Pendulum", "sac", 2),
    ]
    assert shown(replace(VIEW, environment="Acrobot")) == []


@pytest.mark.parametrize(("with_seeds", "points"), [(False, 20), (True, 10)])
def test_all_lines_together_have_a_limited_number_of_points(
    monkeypatch: pytest.MonkeyPatch, with_seeds: bool, points: int
) -> None:
    monkeypatch.setattr(comparison, "MAX_TOTAL_POINTS", 120)
    view = replace(VIEW, with_seeds=with_seeds)
    lengths = {len(one.curve.x) for panel in compared(view).panels for one in panel.curves}
    assert max(lengths) <= points
    assert max(lengths) > points / 2


def test_seconds_of_several_processors_are_told() -> None:
    of_seconds = replace(VIEW, x="seconds")
    assert "Processors" not in definition([compared(of_seconds)])
    runs = [*RUNS[1:], replace(RUNS[0], processor="znver3")]
    for view, is_told in ((of_seconds, True), (VIEW, False)):
        found = definition([compare(runs, ByAlgorithm(runs), view, {}, lambda _: 0.0)])
        assert ("trained these runs: znver3, znver5; seconds" in found) == is_told


def test_a_line_has_two_points_at_least(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(comparison, "MAX_TOTAL_POINTS", 1)
    assert {len(one.curve.x) for one in compared(VIEW).panels[0].curves} == {2}
