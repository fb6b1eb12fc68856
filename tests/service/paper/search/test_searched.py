"""The tables of the search: recomputed from its cells, and as the documentation shows them."""

from collections.abc import Mapping
from pathlib import Path

from service.paper.search import tuning_file
from service.paper.search.searched import searched
from service.paper.search.tuning import SEEDS, SPACES, Outcome

ROOT = Path(__file__).parents[4]


def cells(name: str, task: str, areas: Mapping[int, float]) -> list[Outcome]:
    """All cells of a learner on a task, the places given with their areas, the others with 0."""
    space = SPACES[name]
    return [
        Outcome(
            task, space.algorithm, space.weights, config, areas.get(place, 0.0), 0.0, len(SEEDS), ""
        )
        for place, config in enumerate(space.on(task))
    ]


def row_of(rows: list[Outcome], learner: str, table: int) -> list[str]:
    """The cells of a learner's row in a table."""
    lines = [line for line in searched(rows) if line.startswith(f"| {learner} |")]
    return [cell.strip() for cell in lines[table].strip("|").split("|")][1:]


def test_the_best_area_is_shown_and_nothing_of_a_search_that_goes_on() -> None:
    rows = cells("ddpg", "CartPole", {3: 0.5}) + cells("ddpg", "Pendulum", {1: 0.25})[:-1]
    assert row_of(rows, "ddpg", 0) == ["0.50", *[""] * 8]


def test_a_hybrid_is_compared_with_its_baseline_setting_by_setting() -> None:
    rows = cells("ddpg", "CartPole", dict.fromkeys(range(6), 0.5))
    rows += cells(
        "hybrid-ddpg-robust", "CartPole", {0: 0.25, 1: 0.75} | dict.fromkeys(range(2, 6), 1.0)
    )
    assert row_of(rows, "hybrid-ddpg-robust", 1)[0] == "+0.33 (-0.25, +0.50)"
    assert row_of(rows, "hybrid-td3", 0) == [""] * 9


def test_the_documentation_shows_the_tables_of_the_recorded_search() -> None:
    shown = (ROOT / "docs" / "presets.md").read_text(encoding="utf-8")
    rows = [line for line in searched(tuning_file.read(ROOT / "results")) if line.startswith("|")]
    assert [line for line in rows if line not in shown] == []
