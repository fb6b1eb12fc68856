"""The evaluation as files: measurements, the paper's figures and table, statistics, provenance.

    measurements/<environment>/<algorithm>.csv   a line a measurement; return_mean with all digits
    figure-<n>.svg, figure-<n>.png
    table-1.csv, table-1.md
    statistics.json                              `GET /sweeps/{id}/statistics`, by sweep
    gains.csv                                    service.paper.differences
    provenance.json

An evaluation that goes on can be written too: provenance tells how many of its runs have ended.
"""

import csv
import json
import os
import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

import numpy as np

from service.client import Client, ServiceError
from service.environment import best_return
from service.figures.figure_form import Form
from service.paper.differences import Gain, MeasuredRun, gains
from service.paper.evaluation import FIGURES
from service.run import RunStatus
from service.schemas.run_answer import RunAnswer
from service.schemas.sweep_answer import SweepAnswer

FORMS: tuple[Form, ...] = ("svg", "png")
TABLES: Mapping[Literal["csv", "markdown"], str] = {
    "csv": "table-1.csv",
    "markdown": "table-1.md",
}
KEPT = (
    "timestep",
    "return_mean",
    "updates",
    "jacobians",
    "seconds",
    "action_gradient_cosine",
    "state_gradient_cosine",
)
ROUNDED = {"seconds", "action_gradient_cosine", "state_gradient_cosine"}
"""Columns of which four significant digits are kept; the others' digits are all there."""

Row = Mapping[str, str]


def write(client: Client, sweeps: Sequence[SweepAnswer], folder: Path) -> list[str]:
    """Write the evaluation's files, and return a sentence for each that could not be made."""
    folder.mkdir(parents=True, exist_ok=True)
    lacking: list[str] = []
    evidence: dict[str, Any] = {}
    statistics: dict[str, Any] = {}
    gained: list[Gain] = []
    for sweep in sweeps:
        runs = list(client.runs(sweep.id))
        rows = {run.id: client.measurement_rows(run.id) for run in runs}
        _write_measurements(folder / "measurements", runs, rows)
        lacking += _write_figures(client, sweep, folder)
        evidence[sweep.name] = _provenance(sweep, runs, rows)
        if "4" in FIGURES[sweep.name]:
            _write_table(client, sweep, folder)
        if FIGURES[sweep.name] != ("2",):
            statistics[sweep.name] = client.statistics(sweep.id).model_dump(mode="json")
            ended = (run for run in runs if run.status is RunStatus.SUCCEEDED)
            measured_runs = [_as_arrays(run, rows[run.id]) for run in ended]
            gained += gains(measured_runs, units(client, sweep.id))
    provenance = {"versions": versions(), "machine": machine(), "sweeps": evidence}
    _write_json(folder / "provenance.json", provenance)
    _write_json(folder / "statistics.json", statistics)
    _write_gains(folder / "gains.csv", gained)
    return lacking


def _write_json(file: Path, document: Mapping[str, Any]) -> None:
    file.write_text(json.dumps(document, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def versions() -> dict[str, str]:
    """What the results were made with; `d3pg` is what runs them, the rest is in fingerprints."""
    return {name: version(name) for name in ("d3pg", "ray", "matplotlib", "scipy")}


def machine() -> dict[str, Any]:
    """The machine that wrote the results, which need not be the one of the workers."""
    return {
        "system": platform.platform(),
        "processor": platform.processor() or platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
    }


def units(client: Client, sweep_id: str) -> dict[str, float]:
    """The unit of each task's normalised scale, best minus random return; NaN if not known yet."""
    panels = client.curves(sweep_id, max_points=2).panels
    return {
        panel.environment: best_return(panel.environment)
        - (panel.random_return.mean if panel.random_return else np.nan)
        for panel in panels
    }


def _write_measurements(
    folder: Path, runs: Iterable[RunAnswer], rows: Mapping[str, Sequence[Row]]
) -> None:
    """Write a file an algorithm and task."""
    cells: dict[tuple[str, str], list[RunAnswer]] = {}
    for run in runs:
        cells.setdefault((run.environment, run.algorithm), []).append(run)
    for (environment, algorithm), members in cells.items():
        file = folder / environment / f"{algorithm}.csv"
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("w", encoding="utf-8", newline="") as output:
            writer = csv.writer(output, lineterminator="\n")
            writer.writerow(("w1", "w2", "seed", *KEPT))
            for run in members:
                spec = (run.weights.w1, run.weights.w2, run.seed)
                writer.writerows((*spec, *compact(row)) for row in rows[run.id])


def compact(row: Row) -> Iterator[str]:
    """Yield the columns that are kept; empty where the run has no such diagnostic."""
    for name in KEPT:
        value = row.get(name, "")
        yield f"{float(value):.4g}" if value and name in ROUNDED else value


def _write_figures(client: Client, sweep: SweepAnswer, folder: Path) -> Iterator[str]:
    for number in FIGURES[sweep.name]:
        for form in FORMS:
            try:
                picture = client.figure(sweep.id, form, number)
            except ServiceError as refusal:
                yield f"figure {number} is not there yet: {refusal}"
                break
            (folder / f"figure-{number}.{form}").write_bytes(picture)


def _write_table(client: Client, sweep: SweepAnswer, folder: Path) -> None:
    for form, file in TABLES.items():
        text = client.table_text(sweep.id, form, score="return_history", normalized=True)
        (folder / file).write_text(text, encoding="utf-8", newline="")


def _write_gains(file: Path, gained: Iterable[Gain]) -> None:
    with file.open("w", encoding="utf-8", newline="") as output:
        writer = csv.writer(output, lineterminator="\n")
        writer.writerow(
            ("environment", "algorithm", "w1", "w2", "cost", "n", "wins", "mean", "low", "high")
        )
        writer.writerows(map(_gain_row, gained))


def _gain_row(gain: Gain) -> tuple[object, ...]:
    numbers = (f"{each:.5f}" for each in (gain.mean.value, gain.mean.low, gain.mean.high))
    place = (gain.environment, gain.algorithm, *gain.weights)
    return (*place, gain.cost, gain.n, gain.wins, *numbers)


def _as_arrays(run: RunAnswer, rows: Sequence[Row]) -> MeasuredRun:
    columns = {name: np.array([float(row[name]) for row in rows]) for name in KEPT[:5]}
    weights = (run.weights.w1, run.weights.w2)
    return MeasuredRun(run.algorithm, run.environment, weights, run.seed, columns)


def _provenance(
    sweep: SweepAnswer, runs: Sequence[RunAnswer], rows: Mapping[str, Sequence[Row]]
) -> dict[str, Any]:
    """Who, when, with what: fingerprints are those of the runs, each once."""
    fingerprints = {json.dumps(run.fingerprint, sort_keys=True) for run in runs if run.fingerprint}
    ended = [run.finished_at for run in runs if run.finished_at]
    return {
        "request": sweep.request,
        "runs": sweep.runs.model_dump(),
        "submitted": sweep.created_at.isoformat(),
        "last ended": max(ended).isoformat() if ended else None,
        "core seconds": round(
            sum(float(rows[run.id][-1]["seconds"]) for run in runs if rows[run.id])
        ),
        "attempts": sum(run.attempt for run in runs),
        "fingerprints": [json.loads(text) for text in sorted(fingerprints)],
    }
