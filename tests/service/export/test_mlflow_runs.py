"""Experiments of MLflow, written by its own client and read back by it."""

import math
from pathlib import Path

import pytest

from tests.service.export.measured import two_runs

pytestmark = pytest.mark.filterwarnings("default")  # of MLflow's own use of SQLAlchemy
mlflow_runs = pytest.importorskip(
    "service.export.mlflow_runs", reason="the extra `mlflow` is not installed",
    exc_type=ModuleNotFoundError,
)  # fmt: skip


def test_each_run_is_a_run_of_the_sweeps_experiment(tmp_path: Path) -> None:
    file = tmp_path / "mlflow.db"
    assert mlflow_runs.write(two_runs(), file, "small (3f9a)") == 2
    client = mlflow_runs.mlflow.MlflowClient(tracking_uri=f"sqlite:///{file}")
    experiment = client.get_experiment_by_name("small (3f9a)")
    runs = {run.info.run_name: run for run in client.search_runs([experiment.experiment_id])}
    assert set(runs) == {"3f9a0c51b7de-0", "3f9a0c51b7de-1"}
    first = runs["3f9a0c51b7de-0"]
    assert first.data.params["noise"] == "0.1"
    assert first.info.status == "FINISHED"
    history = client.get_metric_history(first.info.run_id, "return_mean")
    assert [(each.step, each.value, each.timestamp) for each in history] == [
        (800, -8.0, 800), (1600, -16.0, 1600), (2400, -24.0, 2400)
    ]  # fmt: skip
    losses = client.get_metric_history(first.info.run_id, "critic_loss")
    assert math.isnan(losses[1].value)
    with pytest.raises(FileExistsError, match="name another file"):
        mlflow_runs.write(two_runs(), file, "small (3f9a)")
