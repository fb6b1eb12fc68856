"""TensorBoard event files: a folder a run, a scalar a metric, the timestep as the step.

An event's time is the processor time of training until then, so that TensorBoard's relative axis
shows that; the settings are a text beside the curves.
"""

import json
import re
from collections.abc import Iterable
from pathlib import Path

from service.export.measured_run import MeasuredRun
from service.extras import required

tensorboardX = required("tensorboardX", "tensorboard")  # noqa: N816 - the name of the package

UNSAFE = re.compile(r"[^\w=.,+() -]")


def write(runs: Iterable[MeasuredRun], folder: Path, _: str) -> int:
    """Write the events of runs into a folder, and return how many runs there were."""
    count = 0
    for count, run in enumerate(runs, start=1):  # noqa: B007 - the last one is the count
        with tensorboardX.SummaryWriter(str(run_folder(folder, run))) as writer:
            settings = json.dumps(run.settings, indent=2, ensure_ascii=False)
            writer.add_text("settings", f"```json\n{settings}\n```", 0)
            for name, column in run.metrics.items():
                for step, time, value in zip(
                    run.steps, run.columns["seconds"], column, strict=True
                ):
                    writer.add_scalar(name, value, step, walltime=time)
    return count


def run_folder(root: Path, run: MeasuredRun) -> Path:
    """Return `root/Pendulum/ddpg noise=0.1/3f9a0c51b7de-17`; its id tells equal names apart."""
    return root.joinpath(*(UNSAFE.sub("_", part) for part in (run.environment, run.label)), run.id)
