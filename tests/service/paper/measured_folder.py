"""A folder of an evaluation's measurements, for what follows from it."""

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from service.paper.evaluation import row
from service.paper.measured import measurements_file
from workers.training.fingerprint import code_hash

STEPS = range(800, 8001, 800)


class Runs(NamedTuple):
    """Runs of a learner in a task: seed k rises evenly to `heights[k]`."""

    environment: str
    algorithm: str
    heights: Sequence[float]
    config: Mapping[str, Any] = {}
    cost: float = 1.0
    statuses: Mapping[int, str] = {}
    processor: str = "znver5"


def write_folder(folder: Path, runs: Sequence[Runs]) -> None:
    """Write scores.csv, random-returns.csv and the measurements; 0 is random and 10 the best."""
    tasks = sorted({each.environment for each in runs})
    write(folder / "random-returns.csv", [
        {"environment": task, "random": 0.0, "low": 0.0, "high": 0.0, "episodes": 9, "best": 10.0}
        for task in tasks
    ])  # fmt: skip
    write(folder / "scores.csv", [line for each in runs for line in _scores(each)])
    for each in runs:
        file = measurements_file(folder, each.environment, row(each.algorithm, each.config))
        file.parent.mkdir(parents=True, exist_ok=True)
        write(file, [line for seed in range(len(each.heights)) for line in _rows(each, seed)])


def write_evidence(folder: Path, request: Mapping[str, Any], /, **changed: Any) -> None:
    """Write provenance.json and statistics.json of a sweep whose four runs reached their end."""
    counts = {"total": 4, "succeeded": 4, "diverged": 0, "failed": 0, "queued": 0}
    evidence = {
        "request": request, "runs": counts, "fingerprints": [{"code": code_hash()}], **changed
    }  # fmt: skip
    documents = {
        "provenance.json": {"sweeps": {request["name"]: evidence}},
        "statistics.json": {request["name"]: {}},
    }
    for name, document in documents.items():
        (folder / name).write_text(json.dumps(document))


def _scores(runs: Runs) -> list[dict[str, Any]]:
    return [
        {
            "environment": runs.environment, "version": 1, "algorithm": runs.algorithm,
            "w1": 0.0, "w2": 0.0, "config": json.dumps(dict(runs.config)), "seed": seed,
            "timesteps": STEPS[-1], "status": runs.statuses.get(seed, "succeeded"),
            "processor": runs.processor,
            "final": runs.heights[seed], "return_history": "", "area": "",
        }
        for seed in range(len(runs.heights))
    ]  # fmt: skip


def _rows(runs: Runs, seed: int) -> list[dict[str, Any]]:
    return [
        {
            "w1": 0.0, "w2": 0.0, "seed": seed, "timestep": step,
            "return_mean": runs.heights[seed] * step / STEPS[-1],
            "jacobians": 0, "seconds": runs.cost * step / STEPS[-1],
        }
        for step in STEPS
    ]  # fmt: skip


def write(file: Path, lines: Sequence[Mapping[str, Any]]) -> None:
    """Write a CSV file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", encoding="utf-8", newline="") as output:
        writer = csv.DictWriter(output, list(lines[0]))
        writer.writeheader()
        writer.writerows(lines)
