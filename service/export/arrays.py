"""NumPy arrays in the shapes that openrlbenchmark and rliable work on.

openrlbenchmark, by task and entry, the runs in the order of the sweep:

    TASK/ENTRY/global_step             int64 [points]
    TASK/ENTRY/charts/episodic_return  float64 [seeds, points], raw; NaN where not measured
    TASK/ENTRY/_runtime                float64 [seeds, points], processor seconds of training
    TASK/ENTRY/seed                    int64 [seeds]

rliable, by entry, of the tasks that every entry has runs in:

    tasks         str [tasks]
    scores/ENTRY  float64 [seeds, tasks], of the seeds that have a score in all of them
    seeds/ENTRY   int64 [seeds]
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from service.analysis.comparison import grouped
from service.api.schemas.measured.scores_answer import CellScoresAnswer, ScoresAnswer
from service.export.measured_run import MeasuredRun

Arrays = dict[str, NDArray[Any]]
NAMES = {"charts/episodic_return": "return_mean", "_runtime": "seconds"}
"""The columns of openrlbenchmark, and ours."""


def write(arrays: Mapping[str, NDArray[Any]], file: Path) -> None:
    """Write arrays as an .npz file."""
    with file.open("wb") as opened:
        np.savez_compressed(opened, allow_pickle=False, **arrays)


def openrlbenchmark(runs: Iterable[MeasuredRun]) -> Arrays:
    """Return the returns and times of runs, by task and entry."""
    arrays: Arrays = {}
    kept = [_reduced(run) for run in runs]
    for (environment, label), cell in grouped(kept, lambda r: (r.environment, r.label)).items():
        steps = np.unique(np.concatenate([run.columns["timestep"] for run in cell]))
        name = f"{environment}/{label}"
        arrays[f"{name}/global_step"] = steps.astype(np.int64)
        for theirs, ours in NAMES.items():
            arrays[f"{name}/{theirs}"] = np.array([_at(steps, run, ours) for run in cell])
        arrays[f"{name}/seed"] = np.array([run.seed for run in cell], np.int64)
    return arrays


def _reduced(run: MeasuredRun) -> MeasuredRun:
    """Return the run with only the columns that are needed: all of a sweep is held at once."""
    columns = {name: run.columns[name] for name in ("timestep", *NAMES.values())}
    return replace(run, columns=columns)


def _at(steps: NDArray[np.float64], run: MeasuredRun, name: str) -> NDArray[np.float64]:
    values = np.full(len(steps), np.nan)
    values[np.searchsorted(steps, run.columns["timestep"])] = run.columns[name]
    return values


def rliable(scores: ScoresAnswer) -> Arrays:
    """Return the scores of the seeds that have one in every common task.

    Raises ValueError if an entry has none, or no task is common.
    """
    entries = grouped(scores.cells, lambda cell: cell.label)
    tasks = [
        task
        for task in dict.fromkeys(cell.environment for cell in scores.cells)
        if all(any(cell.environment == task for cell in own) for own in entries.values())
    ]
    if not tasks:
        raise ValueError("no task has runs of every entry, and rliable compares over equal tasks")
    arrays: Arrays = {"tasks": np.array(tasks)}
    for label, own in entries.items():
        by_seed = [_scores(cell) for task in tasks for cell in own if cell.environment == task]
        seeds = [seed for seed in by_seed[0] if all(seed in each for each in by_seed)]
        if not seeds:
            raise ValueError(f"no seed of {label!r} has a score in all of {', '.join(tasks)}")
        arrays[f"scores/{label}"] = np.array([[each[seed] for each in by_seed] for seed in seeds])
        arrays[f"seeds/{label}"] = np.array(seeds, np.int64)
    return arrays


def _scores(cell: CellScoresAnswer) -> dict[int, float]:
    """The scores of a cell by seed, of those that have one."""
    known = zip(cell.seeds, cell.values, strict=True)
    return {seed: value for seed, value in known if value is not None}
