"""Figure 7, from an evaluation's files alone."""

import csv
from pathlib import Path

import pytest

from service.paper.evaluation import SWEEPS, row
from service.paper.results import derive
from service.paper.summary import summarized
from service.paper.today import ROWS
from tests.service.paper.measured_folder import Runs, write, write_folder


def numbers(folder: Path) -> dict[tuple[str, str, str], tuple[float, int, int]]:
    """Value, tasks and runs, by learner, statistic and x."""
    with (folder / "figure-7.csv").open(newline="") as file:
        return {
            (line["learner"], line["of"], line["x"]): (
                float(line["value"]), int(line["tasks"]), int(line["runs"]),
            )
            for line in csv.DictReader(file)
        }  # fmt: skip


def test_it_is_drawn_from_the_files(tmp_path: Path) -> None:
    """ddpg reaches 0.4 and shac, at half the time, 0.8; ppo has no ddpg beside it on Hopper."""
    write_folder(tmp_path, [
        Runs("Pendulum", "ddpg", [4.0] * 4),
        Runs("Acrobot", "ddpg", [4.0] * 4),
        Runs("Pendulum", "shac", [8.0] * 4, cost=0.5),
        Runs("Hopper", "ppo", [9.0] * 4),
    ])  # fmt: skip
    derive(tmp_path)
    found = numbers(tmp_path)
    assert {label for label, *_ in found} == {"ddpg", "shac"}
    assert found["ddpg", "interquartile mean by timesteps", "1"] == (0.4, 2, 8)
    assert found["shac", "interquartile mean by timesteps", "0.52"][0] == pytest.approx(0.416)
    by_time = {
        label: [
            v for (own, of, _), (v, *_) in found.items() if own == label and of.endswith("time")
        ]
        for label in ("ddpg", "shac")
    }
    assert by_time["shac"][-1] == 0.8
    ranks = {label: value for (label, of, _), (value, *_) in found.items() if of == "mean rank"}
    assert ranks == {"ddpg": 1.5, "shac": 1.0}, "alone on Acrobot ddpg is the first"
    assert (tmp_path / "figure-7.png").read_bytes().startswith(b"\x89PNG")
    assert b"mean rank" in (tmp_path / "figure-7.svg").read_bytes()


def test_time_is_in_units_of_ddpgs_on_the_same_processor(tmp_path: Path) -> None:
    """On the slow one ddpg takes twice its time: shac there takes 3 of its units."""
    write_folder(tmp_path, [
        Runs("Pendulum", "ddpg", [4.0] * 2),
        Runs("Pendulum", "shac", [8.0] * 2, cost=6.0, processor="slow"),
        Runs("Pendulum", "ppo", [8.0] * 2, processor="of unknown speed"),
    ])  # fmt: skip
    write(tmp_path / "speeds.csv", [
        {"processor": "slow", "environment": "Pendulum", "timesteps": 4000, "seconds": 1.0}
    ])  # fmt: skip
    derive(tmp_path)
    time = "interquartile mean by time"
    found = {(label, x): v for (label, of, x), (v, *_) in numbers(tmp_path).items() if of == time}
    assert {label for label, _ in found} == {"ddpg", "shac"}
    x, value = next((float(x), v) for (label, x), v in found.items() if label == "shac")
    assert value == pytest.approx(0.8 * x / 3.0, abs=1e-3)
    [over_tasks] = [text for text in summarized(tmp_path).split("\n\n") if "mean rank" in text]
    assert [line.split(" | ")[-1] for line in over_tasks.splitlines()[2:]] == ["1 |", "- |", "3 |"]


def test_seeds_beyond_the_sixteenth_and_runs_that_failed_do_not_count(tmp_path: Path) -> None:
    write_folder(tmp_path, [
        Runs("Pendulum", "ddpg", [4.0] * 16 + [9.0] * 16, statuses={3: "diverged", 4: "running"})
    ])  # fmt: skip
    derive(tmp_path)
    assert numbers(tmp_path)["ddpg", "interquartile mean by timesteps", "1"] == (0.4, 1, 14)
    assert "ddpg (1 early)" in (tmp_path / "figure-7.svg").read_text()


def test_before_the_first_run_ends_there_is_none(tmp_path: Path) -> None:
    write_folder(tmp_path, [Runs("Pendulum", "ddpg", [4.0], statuses={0: "running"})])
    derive(tmp_path)
    assert not list(tmp_path.glob("figure-7*"))


def test_every_learner_of_the_evaluation_is_shown() -> None:
    asked = {
        row(algorithm["name"], algorithm.get("config", {}))
        for sweep in SWEEPS
        for algorithm in sweep["algorithms"]
    }
    assert asked == set(ROWS)
