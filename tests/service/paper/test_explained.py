"""The table of where gradients can help, from the CSV that `d3pg diagnose` writes."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from service.cli.results.diagnosing import COLUMNS
from service.paper.explained import FILE, explained
from service.paper.summary import summarized
from tests.service.paper.measured_folder import Runs, write_folder

NUMBERS = [
    ("smoothing", "norm", "8", "0.2", "2.0"),
    ("smoothing", "bias", "8", "0.2", "0.5"),
    ("smoothing", "bias", "8", "0.05", "9.0"),
    ("smoothing", "bias", "16", "0.2", "9.0"),
    ("smoothing", "exact_std", "8", "0.2", "1.0"),
    ("smoothing", "zeroth_std", "8", "0.2", "4.0"),
    ("growth", "median_norm", "32", "", "12.3456"),
    ("loss", "action_top_share", "", "0.2", "0.91"),
    ("critic", "action_cosine", "64", "", "0.3"),
]


Cells = Mapping[tuple[str, str], Sequence[tuple[str, ...]]]


def write(folder: Path, cells: Cells) -> None:
    lines = [",".join(COLUMNS)]
    for (task, learner), numbers in cells.items():
        lines += [",".join((learner, task, "0 1", *each)) for each in numbers]
    (folder / FILE).write_text("\r\n".join(lines) + "\r\n")


def test_a_line_a_task_with_what_each_learner_s_critic_says(tmp_path: Path) -> None:
    robust = [("critic", "action_cosine", "64", "", "0.75")]
    write(
        tmp_path,
        {
            ("Pendulum", "ddpg"): NUMBERS,
            ("Pendulum", "hybrid-ddpg-robust"): robust,
            ("MassPoint", "ddpg"): NUMBERS,
        },
    )
    _, header, rule, *rows = explained(tmp_path)
    assert rows == ["| Pendulum | 0.25 | 0.25 | 12 | 0.91 | 0.3 | 0.75 | - | - |"]
    assert header.count("|") == rule.count("|") == rows[0].count("|")


def test_what_was_not_found_is_said_to_be_so(tmp_path: Path) -> None:
    """Acrobot's exact gradient is 0 far from its end."""
    numbers = [("smoothing", "norm", "8", "0.2", "0.0"), ("smoothing", "bias", "8", "0.2", "0.0")]
    write(tmp_path, {("Acrobot", "ddpg"): [*numbers, ("critic", "action_cosine", "64", "", "")]})
    *_, row = explained(tmp_path)
    assert row == "| Acrobot | - | - | - | - | - | - | - | - |"


def test_the_summary_ends_with_it(tmp_path: Path) -> None:
    write_folder(tmp_path, [Runs("Pendulum", "ddpg", [2.0] * 2)])
    assert "Where gradients can help" not in summarized(tmp_path)
    write(tmp_path, {("Pendulum", "ddpg"): NUMBERS})
    assert summarized(tmp_path).endswith("| - | - | - |")


def test_the_page_shows_the_table_of_the_published_diagnoses() -> None:
    root = Path(__file__).parents[3]
    page = (root / "docs" / "paper.md").read_text(encoding="utf-8")
    rows = [line for line in explained(root / "results") if line.startswith("|")]
    assert len(rows) > 7
    assert [row for row in rows if row not in page] == []
