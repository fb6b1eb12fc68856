"""The figures to hold: read off what commands print, and judged."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from benchmarks.held.figure import Figure, Measured, table
from benchmarks.held.figures import FIGURES

ROOT = Path(__file__).parents[3]
MOST = Figure("how long", ("benchmarks.x",), "took: # s", 5.0, "s")
LEAST = Figure("how many", ("benchmarks.x",), "made: # 1/s", 50_000.0, "1/s", is_least=True)
TESTS = Figure("no crash", ("pytest", "tests"))
PRINTED = {
    "requests": "10,000 runs submitted over REST: 0.68 s (to hold: 5 s)\n"
    "SIGTERM to the end, 50 streams open: 2.70 s (to hold: 5 s)\n",
    "overview": f"{'curves':34}{0.27:8.3f}{0.2:8.3f}{680:8.0f}{120:9.0f}\n"
    f"{'curves, unchanged (304)':34}{9.0:8.3f}{9.0:8.3f}{0:8.0f}{20:9.0f}\n",
    "large_sweep": f"{'/curves':36}{1.5:8.2f}{1.4:8.2f}{182:9.0f}{90:8.0f}{'200':>8}\n"
    f"{'/table?score=area':36}{2.9:8.2f}{1.4:8.2f}{150:9.0f}{90:8.0f}{'200':>8}\n"
    f"{'/curves, 16 at once':36}{60.0:8.2f}{20.0:8.2f}{314:9.0f}{90:8.0f}{'200/503':>8}\n",
    "dispatch": "a run's overhead, median: 0.0151 s\n"
    "/healthz while two workers train, p99: 6.5 ms\n",
    "training_seconds": "sac: training, farthest from its median: 2.1 %\n"
    "sac: the same, farthest: 6.9 %\ngd: the same, farthest: 3.3 %\n",
    "store": "SQLite, measurements taken in: 6.69e+04 1/s\n"
    "PostgreSQL, measurements taken in: 3.5e+04 1/s\n",
    "many_workers": "SQLite, 1,000 workers, a worker's time lost: 0.17 %\n"
    "PostgreSQL, 100 workers, a worker's time lost: 9 %\n"
    "PostgreSQL, 1,000 workers, a worker's time lost: 2.8 %\n",
    "two_workers": "two workers / one, at best 2: 1.95\n",
    "short_horizon": "Pendulum, whole updates, steps a second:\n"
    "    a run alone: 9,000 (a run alone: 1.0 times)\n"
    "    torch's loop: 800 (a run alone: 2.0 times)\n"
    "Pendulum, windows and the actor's step, steps a second:\n"
    "    a run alone: 9,000 (a run alone: 1.0 times)\n"
    "    torch's loop: 1,800 (a run alone: 4.5 times)\n"
    "    torch's loop, one environment at a time: 41 (a run alone: 221.0 times)\n",
    "robots": "Hopper step over MuJoCo's: 0.5 x\nHopper step over MuJoCo's of Euler's: 0.14 x\n"
    "MuJoCo's Jacobian over Hopper differentiate: 29 x\n",
    "simulators": "Ant, batch 16, step over mujoco.rollout: 0.9 x\n"
    "Ant, batch 1, step over mujoco.rollout: 0.2 x\n",
}
"""Lines as the benchmarks print them."""
WORST = {
    "requests": [0.68, 2.7],
    "overview": [0.27, 680],
    "large_sweep": [2.9, 182, 314],
    "dispatch": [6.5, 0.0151],
    "training_seconds": [2.1, 6.9],
    "store": [66_900, 35_000],
    "many_workers": [0.17, 2.8],
    "two_workers": [1.95],
    "short_horizon": [221, 4.5],
    "robots": [0.14, 29],
    "simulators": [0.9],
}


@pytest.mark.parametrize(
    ("figure", "printed", "measured", "held"),
    [
        (MOST, "took: 4.5 s\ntook: 1,234.5 s\n", "1,234.5 s", "no"),
        (MOST, "took: 5 s\n", "5 s", "yes"),
        (LEAST, "made: 6.69e+04 1/s\nmade: 5e+04 1/s", "50,000 1/s", "yes"),
        (LEAST, "made: 35,000 1/s", "35,000 1/s", "no"),
        (MOST, "an error\n", "nothing (exit code 0)", "not measured"),
        (TESTS, "1 passed", "passed", "yes"),
    ],
)
def test_the_worst_that_was_printed_is_judged(
    figure: Figure, printed: str, measured: str, held: str
) -> None:
    assert Measured.of(figure, printed, 0) == Measured(figure, measured, held)


def test_tests_that_fail_hold_nothing() -> None:
    assert Measured.of(TESTS, "1 failed", 1).held == "no"


def test_a_table_has_a_line_for_each() -> None:
    rows = [Measured.of(MOST, "took: 4.5 s", 0), Measured.of(TESTS, "", 1)]
    assert table(rows).splitlines() == [
        "| figure | goal | measured | held |",
        "| --- | --- | --- | --- |",
        "| how long | <= 5 s | 4.5 s | yes |",
        "| no crash | passes | failed | no |",
    ]


def test_every_benchmark_s_figure_is_found_in_what_it_prints() -> None:
    found: dict[str, list[float | None]] = {}
    for figure in FIGURES:
        if figure.limit is not None:
            name = figure.command[0].removeprefix("benchmarks.")
            found.setdefault(name, []).append(figure.worst(PRINTED[name]))
    assert found == WORST


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.name)
def test_what_measures_it_is_there_and_documented(figure: Figure) -> None:
    module, *words = figure.command
    assert find_spec(module) is not None
    if words:
        assert (ROOT / words[-1]).is_file()
    documented = (ROOT / "docs/figures-to-hold.md").read_text()
    assert (words[-1] if words else f"python -m {module}") in documented
