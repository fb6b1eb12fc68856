"""The summary of an evaluation, from its files alone."""

from pathlib import Path

from service.paper.summary import summarized
from tests.service.paper.measured_folder import Runs, write_folder

ROOT = Path(__file__).parents[3]


def lines(folder: Path) -> list[str]:
    return summarized(folder).splitlines()


def test_verdicts_are_counted_at_equal_timesteps_and_at_equal_time(tmp_path: Path) -> None:
    """The hybrid reaches twice as far in the same timesteps, at four times the time."""
    write_folder(tmp_path, [
        Runs("Pendulum", "td3", [2.0] * 10),
        Runs("Pendulum", "hybrid-td3", [4.0] * 10, cost=4.0),
        Runs("CartPole", "td3", [2.0] * 10),
        Runs("CartPole", "hybrid-td3", [4.0] * 10, cost=4.0, statuses={9: "failed"}),
    ])  # fmt: skip
    found = lines(tmp_path)
    assert found[0] == "## hybrid-td3 minus its baseline"
    assert found[2].startswith("- equal timesteps: better on 2, behind on 0, not told apart on 0, ")
    assert found[2].endswith("not known on 5 of the paper's 7 tasks")
    assert found[3].startswith("- equal processor time: better on 0, behind on 2, ")
    [pendulum] = [line for line in found if line.startswith("| Pendulum")]
    assert "**+0.110** [0.110, 0.110], p 0.014, 10 of 10, better" in pendulum
    assert pendulum.endswith("0 of 10, behind |")
    [cart] = [line for line in found if line.startswith("| CartPole")]
    assert "9 of 9, 1 failed, better" in cart


def test_learners_on_the_cheetah_are_listed_the_best_first(tmp_path: Path) -> None:
    write_folder(tmp_path, [
        Runs("HalfCheetah", "ddpg", [4.0, 4.0]),
        Runs("HalfCheetah", "sac", [8.0, 8.0], {"temperature": "learned"}),
        Runs("HalfCheetah", "shac", [9.0, 9.0], statuses={0: "running", 1: "running"}),
    ])  # fmt: skip
    *_, first, second, third = lines(tmp_path)
    assert first == ("| sac with learned temperature | 0.800 [0.800, 0.800] | 0.440 | 2 of 2 |")
    assert second.startswith("| ddpg | 0.400")
    assert third == "| shac | - | - | 0 of 2 |"


def test_learners_are_told_over_all_tasks_and_in_each(tmp_path: Path) -> None:
    """shac reaches twice as far as ddpg in half its time; td3 takes ten times as long."""
    write_folder(tmp_path, [
        Runs("Pendulum", "ddpg", [4.0] * 4),
        Runs("Acrobot", "ddpg", [2.0] * 4),
        Runs("Pendulum", "shac", [8.0] * 4, cost=0.5),
        Runs("Acrobot", "td3", [1.0] * 4, cost=10.0),
    ])  # fmt: skip
    found = lines(tmp_path)
    first = found.index("## The learners of today")
    over, each = (
        [line for line in part if line.startswith("| ")]
        for part in (found[first : first + 8], found[first + 8 : first + 15])
    )
    assert over[1:] == [
        "| ddpg | 2 | 8 | 0.30 [0.30, 0.30] | 0.30 [0.30, 0.30] | 1.5 [1.5, 1.5] | 1 |",
        "| td3 | 1 | 4 | 0.10 [0.10, 0.10] | - | 2.0 [2.0, 2.0] | 10 |",
        "| shac | 1 | 4 | 0.80 [0.80, 0.80] | 0.80 [0.80, 0.80] | 1.0 [1.0, 1.0] | 0.5 |",
    ]
    assert each == [
        "| learner | Pendulum | Acrobot |",
        "| ddpg | 0.40 | 0.20 |",
        "| td3 | - | 0.10 |",
        "| shac | 0.80 | - |",
    ]


def test_the_page_shows_the_tables_of_the_published_measurements() -> None:
    """Of hybrids whose sweeps have begun, every line."""
    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    gains, _, _ = summarized(ROOT / "results").partition("## HalfCheetah")
    rows = [line for line in gains.splitlines() if line.startswith("| ")]
    assert len(rows) > 7
    assert [row for row in rows if row not in page] == []
