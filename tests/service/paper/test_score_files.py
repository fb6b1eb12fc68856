"""What every run came to, as files."""

import csv
from pathlib import Path
from typing import Any

import pytest

from service.api.schemas.curves_answer import RandomReturnAnswer
from service.api.schemas.run_answer import RunAnswer, WeightsAnswer
from service.model.run import RunStatus
from service.paper.score_files import write_random_returns, write_scores


def run(seed: int, status: RunStatus = RunStatus.SUCCEEDED) -> RunAnswer:
    return RunAnswer.model_construct(
        algorithm="hybrid-ddpg", environment="Pendulum", environment_version=1, seed=seed,
        weights=WeightsAnswer(w1=1.0, w2=0.01), config={"noise": 0.2}, timesteps=1600,
        status=status, fingerprint={"processor": "znver5"} if status.is_final else None,
    )  # fmt: skip


def row(timestep: int, return_mean: str, return_history: str) -> dict[str, str]:
    return {
        "timestep": str(timestep),
        "return_mean": return_mean,
        "return_history": return_history,
    }


def lines(file: Path) -> list[dict[str, Any]]:
    with file.open(encoding="utf-8", newline="") as text:
        return list(csv.DictReader(text))


def test_a_run_has_its_three_scores_raw(tmp_path: Path) -> None:
    rows = [row(800, "-3.0", "-3.0"), row(1600, "-1.0", "-2.0")]
    write_scores(tmp_path / "scores.csv", [(run(0), rows)])
    [line] = lines(tmp_path / "scores.csv")
    assert line == {
        "environment": "Pendulum", "version": "1", "algorithm": "hybrid-ddpg", "w1": "1.0",
        "w2": "0.01", "config": '{"noise": 0.2}', "seed": "0", "timesteps": "1600",
        "status": "succeeded", "processor": "znver5",
        "final": "-1.0", "return_history": "-2.0", "area": "-2.0",
    }  # fmt: skip


@pytest.mark.parametrize("status", [RunStatus.QUEUED, RunStatus.FAILED])
def test_what_was_not_measured_has_no_score_and_says_how_it_stands(
    tmp_path: Path, status: RunStatus
) -> None:
    write_scores(tmp_path / "scores.csv", [(run(3, status), [])])
    [line] = lines(tmp_path / "scores.csv")
    assert (line["seed"], line["status"]) == ("3", status.value)
    assert {line[name] for name in ("final", "return_history", "area")} == {""}


def test_a_diverged_value_is_written_as_it_is(tmp_path: Path) -> None:
    rows = [row(1600, "-Infinity", "NaN")]
    write_scores(tmp_path / "scores.csv", [(run(0, RunStatus.DIVERGED), rows)])
    [line] = lines(tmp_path / "scores.csv")
    assert (line["final"], line["return_history"], line["area"]) == ("-inf", "nan", "-inf")


def test_the_scale_of_a_task_is_its_random_and_best_return(tmp_path: Path) -> None:
    """Pendulum's largest reward is 0 at each step; a task without a random return has no line."""
    zero = RandomReturnAnswer(mean=-1200.5, low=-1210.0, high=-1191.0, episodes=1000)
    write_random_returns(tmp_path / "random-returns.csv", {"Pendulum": zero, "Acrobot": None})
    [line] = lines(tmp_path / "random-returns.csv")
    assert line == {
        "environment": "Pendulum", "random": "-1200.5", "low": "-1210.0", "high": "-1191.0",
        "episodes": "1000", "best": "0.0",
    }  # fmt: skip
