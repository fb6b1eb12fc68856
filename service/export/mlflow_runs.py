"""MLflow: an experiment a sweep, by its own client, in a database that needs no server.

The timestep is the step, and a metric's time is the processor time of training until then.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from service.export.measured_run import MeasuredRun
from service.extras import required

mlflow = required("mlflow", "mlflow")
entities = required("mlflow.entities", "mlflow")

MOST_AT_ONCE = 1000
"""Metrics in a request, MLflow's own limit."""


def write(runs: Iterable[MeasuredRun], database: Path, sweep: str) -> int:
    """Add the runs of a sweep to a SQLite file, and return how many there were.

    Raises FileExistsError if its experiment exists already.
    """
    client = mlflow.MlflowClient(tracking_uri=f"sqlite:///{database.resolve()}")
    if client.get_experiment_by_name(sweep) is not None:
        raise FileExistsError(f"{database} has the experiment {sweep!r} already: name another file")
    experiment = client.create_experiment(sweep)
    count = 0
    for count, run in enumerate(runs, start=1):  # noqa: B007 - the last one is the count
        _write(client, experiment, run)
    return count


def _write(client: Any, experiment: str, run: MeasuredRun) -> None:
    made = client.create_run(experiment, run_name=run.id, tags={"label": run.label}).info.run_id
    params = [entities.Param(name, str(value)) for name, value in run.settings.items()]
    times = [int(1000 * seconds) for seconds in run.columns["seconds"]]
    metrics = [
        entities.Metric(name, float(value), time, step)
        for name, column in run.metrics.items()
        for step, time, value in zip(run.steps, times, column, strict=True)
    ]
    client.log_batch(made, params=params)
    for start in range(0, len(metrics), MOST_AT_ONCE):
        client.log_batch(made, metrics=metrics[start : start + MOST_AT_ONCE])
    client.set_terminated(made)
