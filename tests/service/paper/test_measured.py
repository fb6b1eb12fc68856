"""Runs read from an evaluation's files."""

from pathlib import Path

import numpy as np

from service.paper.measured import read_runs, read_scales
from tests.service.paper.measured_folder import STEPS, Runs, write_folder
from workers.messages.run_spec import NO_WEIGHTS


def test_runs_are_read_with_their_measurements(tmp_path: Path) -> None:
    write_folder(tmp_path, [
        Runs("Pendulum", "ddpg", [5.0, 10.0], statuses={1: "diverged"}),
        Runs("Pendulum", "sac", [1.0]),
        Runs("Pendulum", "sac", [2.0], {"temperature": "learned"}),
    ])  # fmt: skip
    first, second, sac, learned = read_runs(tmp_path)
    assert (first.environment, first.algorithm, first.weights) == ("Pendulum", "ddpg", NO_WEIGHTS)
    assert [(run.seed, run.status) for run in (first, second)] == [
        (0, "succeeded"),
        (1, "diverged"),
    ]
    assert first.timesteps == STEPS[-1]
    np.testing.assert_array_equal(first.columns["timestep"], STEPS)
    np.testing.assert_allclose(first.columns["return_mean"], np.linspace(0.5, 5.0, len(STEPS)))
    assert (sac.row, learned.row) == ("sac", "sac with learned temperature")
    assert [run.columns["return_mean"][-1] for run in (sac, learned)] == [1.0, 2.0]
    scale = read_scales(tmp_path)["Pendulum"]
    assert (scale.random, scale.unit) == (0.0, 10.0)


def test_a_run_that_has_not_begun_has_no_measurements(tmp_path: Path) -> None:
    write_folder(tmp_path, [Runs("Pendulum", "ddpg", [5.0, 10.0], statuses={1: "queued"})])
    file = tmp_path / "measurements/Pendulum/ddpg.csv"
    file.write_text("".join(file.read_text().splitlines(keepends=True)[: 1 + len(STEPS)]))
    _, queued = read_runs(tmp_path)
    assert {name: len(values) for name, values in queued.columns.items()} == {
        "timestep": 0, "return_mean": 0, "jacobians": 0, "seconds": 0
    }  # fmt: skip
    file.unlink()
    assert [len(run.columns["timestep"]) for run in read_runs(tmp_path)] == [0, 0]
