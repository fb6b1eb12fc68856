"""The evaluation as files: measurements, the paper's figures and table, statistics, provenance.

    measurements/<environment>/<learner>.csv   a line a measurement; returns with all digits
    scores.csv, random-returns.csv             service.paper.score_files
    figure-<n>.svg, figure-<n>.png
    table-1.csv, table-1.md
    statistics.json                            `GET /sweeps/{id}/statistics`, by sweep
    gains.csv                                  service.paper.differences
    figure-7.svg, .png and .csv                service.paper.today
    provenance.json

The numbers of tables, statistics, gains and figure 7 follow from measurements, scores and random
returns. An unfinished evaluation can be written, too: provenance says how many of its runs have
ended.
"""

import csv
import json
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

import numpy as np

from service.analysis.comparison import grouped
from service.analysis.figures.figure_form import Form
from service.analysis.figures.paper_figure import FigureNumber
from service.api.schemas.curves_answer import RandomReturnAnswer
from service.api.schemas.run_answer import RunAnswer
from service.api.schemas.sweep_answer import SweepAnswer
from service.client import Client, ServiceError
from service.paper import measured, speeds
from service.paper.differences import gains
from service.paper.evaluation import FIGURES, row
from service.paper.former import NOTHING, Former
from service.paper.gain_file import write_gains
from service.paper.score_files import Row, write_random_returns, write_scores
from service.paper.today import write_figure

FORMS: tuple[Form, ...] = ("svg", "png")
TABLES: Mapping[Literal["csv", "markdown"], str] = {
    "csv": "table-1.csv",
    "markdown": "table-1.md",
}
KEPT = (
    "timestep",
    "return_mean",
    "return_history",
    "updates",
    "jacobians",
    "seconds",
    "compile_seconds",
    "action_gradient_cosine",
    "state_gradient_cosine",
)
ROUNDED = {"seconds", "compile_seconds", "action_gradient_cosine", "state_gradient_cosine"}
"""Columns with four significant digits; the others keep all digits."""


class NotYetError(Exception):
    """A result cannot be made from the measurements so far."""


@dataclass(frozen=True)
class Swept:
    """A sweep with its measurements, and the service's results of it.

    rows        the measurements as they are kept, by run
    zeros       the zero of the normalised scale, by task; None if not known yet
    statistics  `GET /sweeps/{id}/statistics`; None of a critic, which says nothing of its learner
    tables      the text of table 1, by file; none unless the sweep is that of table 1
    """

    sweep: SweepAnswer
    runs: Sequence[RunAnswer]
    rows: Mapping[str, Sequence[Row]]
    zeros: Mapping[str, RandomReturnAnswer | None]
    statistics: Mapping[str, Any] | None
    tables: Mapping[str, str]

    @classmethod
    def of(cls, client: Client, sweep: SweepAnswer) -> "Swept":
        """Read it; again if a run began or ended meanwhile, so that all is of one state."""
        while True:
            before = client.sweep(sweep.id)
            found = cls._asked(client, before)
            if client.sweep(sweep.id).runs == before.runs:
                return found

    @classmethod
    def _asked(cls, client: Client, sweep: SweepAnswer) -> "Swept":
        runs = list(client.runs(sweep.id))
        rows: dict[str, list[Row]] = {run.id: [] for run in runs}
        for line in client.sweep_rows(sweep.id):
            rows[line["run"]].append(kept(line))
        panels = client.curves(sweep.id, max_points=2).panels
        zeros = {panel.environment: panel.random_return for panel in panels}
        numbers = figures_of(sweep)
        statistics = (
            client.statistics(sweep.id).model_dump(mode="json") if numbers != ("2",) else None
        )
        tables = TABLES if "4" in numbers else {}
        texts = {
            file: client.table_text(sweep.id, form, score="return_history", normalized=True)
            for form, file in tables.items()
        }
        return cls(sweep, runs, rows, zeros, statistics, texts)


def write(
    client: Client, sweeps: Sequence[SweepAnswer], folder: Path, kept: Former = NOTHING
) -> list[str]:
    """Write the evaluation's files, and return a sentence for each that could not be made.

    Results kept from other sweeps are written with them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    swept = [Swept.of(client, sweep) for sweep in sweeps]
    runs = [(run, one.rows[run.id]) for one in swept for run in one.runs]
    zeros = {task: zero for one in swept for task, zero in one.zeros.items()}
    for one in swept:
        _write_measurements(folder, one)
        for file, text in one.tables.items():
            (folder / file).write_text(text, encoding="utf-8", newline="")
    write_scores(folder / "scores.csv", runs, kept.scores)
    write_random_returns(folder / "random-returns.csv", zeros, kept.random_returns)
    statistics = {one.sweep.name: one.statistics for one in swept if one.statistics is not None}
    _write_json(folder / "statistics.json", {**kept.statistics, **statistics})
    evidence = {**kept.evidence, **{one.sweep.name: _provenance(one) for one in swept}}
    made = {"versions": versions(), "machine": machine(), "sweeps": evidence}
    _write_json(folder / "provenance.json", made)
    derive(folder)
    return [sentence for one in swept for sentence in _write_figures(client, one, folder)]


def derive(folder: Path) -> None:
    """Write the results of the files of measurements, scores and random returns."""
    runs, scales = measured.read_runs(folder), measured.read_scales(folder)
    write_gains(folder / "gains.csv", gains(runs, scales))
    write_figure(folder, runs, scales, speeds.slowness(folder))


def figures_of(sweep: SweepAnswer) -> tuple[FigureNumber, ...]:
    """The figures that the service draws from a sweep."""
    return FIGURES.get(sweep.name, ())


def _write_json(file: Path, document: Mapping[str, Any]) -> None:
    file.write_text(json.dumps(document, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def versions() -> dict[str, str]:
    """The versions that made the results; `d3pg` runs them, the rest is in fingerprints."""
    return {name: version(name) for name in ("d3pg", "ray", "matplotlib", "scipy")}


def machine() -> dict[str, Any]:
    """The machine that wrote the results, which need not be the one of the workers."""
    return {
        "system": platform.platform(),
        "processor": platform.processor() or platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
    }


def _write_measurements(folder: Path, swept: Swept) -> None:
    """Write a file for each learner and task; if no run has begun, remove an earlier file."""
    cells = grouped(swept.runs, lambda run: (run.environment, row(run.algorithm, run.config)))
    for cell, members in cells.items():
        file = measured.measurements_file(folder, *cell)
        if not any(swept.rows[run.id] for run in members):
            file.unlink(missing_ok=True)
            continue
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("w", encoding="utf-8", newline="") as output:
            writer = csv.writer(output, lineterminator="\n")
            writer.writerow(("w1", "w2", "seed", *KEPT))
            for run in members:
                spec = (*run.weights.pair, run.seed)
                writer.writerows((*spec, *row.values()) for row in swept.rows[run.id])


def kept(row: Row) -> Row:
    """Return the columns that are kept; empty where the run has no such diagnostic."""
    return {name: _rounded(name, row.get(name, "")) for name in KEPT}


def _rounded(name: str, value: str) -> str:
    return f"{float(value):.4g}" if value and name in ROUNDED else value


def _write_figures(client: Client, swept: Swept, folder: Path) -> Iterator[str]:
    """Write the figures of a sweep; if one cannot be drawn yet, remove an earlier file."""
    for number in figures_of(swept.sweep):
        files = {form: folder / f"figure-{number}.{form}" for form in (*FORMS, "csv")}
        try:
            found = _figure(client, swept, number)
        except (NotYetError, ServiceError) as reason:
            for file in files.values():
                file.unlink(missing_ok=True)
            yield f"figure {number} is not there yet: {reason}"
            continue
        for form, content in found.items():
            files[form].write_bytes(content)


def _figure(client: Client, swept: Swept, number: FigureNumber) -> dict[str, bytes]:
    """Fetch the files of a figure, by form. Raises NotYetError, or the service's refusal."""
    if not any(swept.rows.values()):
        raise NotYetError("no run of it has measured anything")
    files = {str(form): client.figure(swept.sweep.id, form, number) for form in FORMS}
    return {**files, "csv": client.figure_data(swept.sweep.id, number).encode()}


def _provenance(swept: Swept) -> dict[str, Any]:
    """The origin of the results: fingerprints are those of the runs, each once."""
    runs = swept.runs
    fingerprints = {json.dumps(run.fingerprint, sort_keys=True) for run in runs if run.fingerprint}
    ended = [run.finished_at for run in runs if run.finished_at]
    return {
        "request": swept.sweep.request,
        "runs": swept.sweep.runs.model_dump(),
        "submitted": swept.sweep.created_at.isoformat(),
        "last ended": max(ended).isoformat() if ended else None,
        "core seconds": _spent(swept, "seconds"),
        "compile core seconds": _spent(swept, "compile_seconds"),
        "attempts": sum(run.attempt for run in runs),
        "fingerprints": [json.loads(text) for text in sorted(fingerprints)],
    }


def _spent(swept: Swept, name: str) -> int:
    """Seconds of all runs, as far as they are known."""
    last = [float(rows[-1][name]) for rows in swept.rows.values() if rows]
    return round(float(np.nansum(last)))
