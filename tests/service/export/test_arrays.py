"""Arrays in the shapes of other tools."""

from pathlib import Path

import numpy as np
import pytest

from service.api.schemas.measured.scores_answer import CellScoresAnswer, ScoresAnswer
from service.export.arrays import openrlbenchmark, rliable, write
from tests.service.export.measured import two_runs


def scores(*cells: tuple[str, str, list[int], list[float | None]]) -> ScoresAnswer:
    shown = [
        CellScoresAnswer(environment=task, label=label, algorithm=label, seeds=seeds, values=values)
        for task, label, seeds, values in cells
    ]
    return ScoresAnswer(sweep="x", score="final", normalized=True, cells=shown)


def test_runs_of_a_cell_are_rows_over_common_steps(tmp_path: Path) -> None:
    file = tmp_path / "bench.npz"
    write(openrlbenchmark(two_runs()), file)
    with np.load(file) as opened:
        read = dict(opened)
    cell = "Pendulum(gravity=8)/ddpg noise=0.1"
    assert read[f"{cell}/global_step"].tolist() == [800, 1600, 2400]
    returns = read[f"{cell}/charts/episodic_return"]
    assert returns.shape == (2, 3)
    assert returns[0].tolist() == [-8.0, -16.0, -24.0]
    assert returns[1, :2].tolist() == [-8.0, -16.0]
    assert np.isnan(returns[1, 2])
    assert read[f"{cell}/_runtime"][0].tolist() == [0.8, 1.6, 2.4]
    assert read[f"{cell}/seed"].tolist() == [0, 1]


def test_scores_are_matrices_of_seeds_and_common_tasks() -> None:
    arrays = rliable(
        scores(
            ("Pendulum", "a", [0, 1, 2], [0.1, 0.2, None]),
            ("Pendulum", "b", [0, 1], [0.3, 0.4]),
            ("Acrobot", "a", [0, 1, 2], [0.5, 0.6, 0.7]),
            ("Acrobot", "b", [1, 0], [0.8, 0.9]),
            ("CartPole", "b", [0, 1], [1.0, 1.0]),
        )
    )
    assert arrays["tasks"].tolist() == ["Pendulum", "Acrobot"]
    assert arrays["scores/a"].tolist() == [[0.1, 0.5], [0.2, 0.6]]
    assert arrays["scores/b"].tolist() == [[0.3, 0.9], [0.4, 0.8]]
    assert arrays["seeds/a"].tolist() == [0, 1]


def test_what_cannot_be_a_matrix_is_told() -> None:
    with pytest.raises(ValueError, match="no task has runs of every entry"):
        rliable(scores(("Pendulum", "a", [0], [0.1]), ("Acrobot", "b", [0], [0.1])))
    with pytest.raises(ValueError, match="no seed of 'a' has a score in all of Pendulum"):
        rliable(scores(("Pendulum", "a", [0], [None])))
