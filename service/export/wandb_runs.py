"""Weights & Biases: offline runs by its own client, which `wandb sync` uploads when it is asked to.

A run is one of W&B's, in a group of its entry and task, with the timestep as the step.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from service.export.measured_run import MeasuredRun
from service.extras import required

wandb = required("wandb", "wandb")

PROJECT = "d3pg"


def write(runs: Iterable[MeasuredRun], folder: Path, sweep: str) -> int:
    """Write offline runs of a sweep into a folder, and return how many there were."""
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for count, run in enumerate(runs, start=1):  # noqa: B007 - the last one is the count
        _write(run, folder, sweep)
    wandb.teardown()  # its process writes the files; this waits for it to end
    return count


def _write(run: MeasuredRun, folder: Path, sweep: str) -> None:
    quiet = wandb.Settings(
        silent=True,
        console="off",
        disable_git=True,
        save_code=False,
        x_disable_meta=True,
        x_disable_stats=True,
        x_save_requirements=False,
    )
    written = wandb.init(
        mode="offline",
        dir=str(folder),
        project=PROJECT,
        name=run.id,
        group=f"{run.label} in {run.environment}",
        config={"sweep": sweep, **run.settings},
        settings=quiet,
        reinit="create_new",
    )
    table = np.array(list(run.metrics.values()))
    for step, values in zip(run.steps, table.T, strict=True):
        written.log(dict(zip(run.metrics, values.tolist(), strict=True)), step=step)
    written.finish()
