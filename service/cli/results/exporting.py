"""`d3pg export`, `table` and `plot`: what was measured, as files."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from service.analysis.figures.paper_figure import FigureNumber
from service.analysis.statistics.score import Score
from service.api.schemas.measured.measurements_answer import SPEC_COLUMNS
from service.api.schemas.run_answer import RunAnswer
from service.api.schemas.score_table_answer import StandingAnswer, inert
from service.cli.identifiers import Identifier, SweepId
from service.cli.results.converting import SUFFIXES, Format, convert
from service.cli.results.drawing import form_of, save_figure
from service.cli.terminal import AsJson, print_json, print_table, say, write_out
from service.client import Client, TableText
from service.model.run_name import is_run

Row = dict[str, Any]


def export(
    identifier: Identifier,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A file or, for tensorboard and wandb, a new folder."),
    ] = None,
    form: Annotated[
        Format | None,
        typer.Option("--format", help="Form to write; by the file's suffix if unset, else csv."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write every measurement of a sweep or a run as CSV, or a sweep for other tools.

    mlflow adds an experiment to a SQLite file; openrlbenchmark and rliable are NumPy archives; a
    report is an HTML file that needs no service, of a sweep or of several (`3f9a+b2`).
    """
    form = form or (SUFFIXES.get(output.suffix, "csv") if output else "csv")
    if form != "csv":
        _for_others(identifier, form, output, as_json)
        return
    with Client() as client:
        if as_json:
            for run in runs_of(client, identifier):
                print_json(client.measurements(run.id), indent=None)
            return
        if output is None:
            text = _run_csv(client, identifier)
            write_out([text] if text else client.sweep_csv_parts(identifier))
            return
        if text := _run_csv(client, identifier):
            output.write_text(text, encoding="utf-8", newline="")
        else:
            client.save_measurements(identifier, output)
    with output.open(encoding="utf-8", newline="") as file:
        lines = sum(1 for _ in csv.reader(file))
    say(f"Wrote {lines - 1} measurements to {output}")


def _run_csv(client: Client, identifier: str) -> str:
    """The measurements of a run as CSV; empty for a sweep, which is too large for a text."""
    if not is_run(identifier):
        return ""
    return written(list(measurement_rows(client, runs_of(client, identifier))))


def _for_others(identifier: str, form: Format, output: Path | None, as_json: bool) -> None:
    """Write a sweep for another tool. Raises BadParameter for a run, and without an output."""
    if is_run(identifier):
        raise typer.BadParameter(f"a run can be exported as csv alone, not as {form}")
    if output is None:
        raise typer.BadParameter(
            f"{form} cannot be printed: name a file or folder", param_hint="--output"
        )
    with Client() as client:
        written, opened = convert(form, client, identifier, output)
    told = ", ".join(f"{count} {what}" for what, count in written.items() if what != "output")
    say(json.dumps(written) if as_json else f"Wrote {told} to {output}: {opened}")


def runs_of(client: Client, identifier: str) -> Iterator[RunAnswer]:
    """The run, or the runs of the sweep."""
    return iter([client.run(identifier)]) if is_run(identifier) else client.runs(identifier)


def measurement_rows(client: Client, runs: Iterable[RunAnswer]) -> Iterator[Row]:
    """Yield a row a measurement; its first columns say which run it belongs to."""
    for run in runs:
        config = json.dumps(run.config, sort_keys=True)
        spec = (run.id, inert(run.label), inert(run.algorithm), inert(run.environment),
                *run.weights.pair, inert(config), run.seed)  # fmt: skip
        for row in client.measurement_rows(run.id):
            yield dict(zip(SPEC_COLUMNS, spec, strict=True)) | row


def written(rows: list[Row]) -> str:
    """Rows as CSV (RFC 4180); a cell is empty where a run has no such diagnostic."""
    columns = dict.fromkeys((*SPEC_COLUMNS, *(name for row in rows for name in row)))
    file = io.StringIO()
    writer = csv.DictWriter(file, list(columns))
    writer.writeheader()
    writer.writerows(rows)
    return file.getvalue()


def table(
    sweep_id: SweepId,
    form: Annotated[
        TableText | None,
        typer.Option("--format", help="Print text in this form; a table if unset."),
    ] = None,
    score: Annotated[
        Score,
        typer.Option(
            help="final: the run's end; return_history: the paper's table 1; area: the whole run."
        ),
    ] = "final",
    raw: Annotated[bool, typer.Option("--raw", help="Raw returns, not normalised.")] = False,
    as_json: AsJson = False,
) -> None:
    """Print what every learner reached in every task."""
    with Client() as client:
        if form is not None and not as_json:
            write_out([client.table_text(sweep_id, form, score=score, normalized=not raw)])
            return
        answer = client.table(sweep_id, score=score, normalized=not raw)
    if as_json:
        print_json(answer)
        return
    print_table(
        ("learner", *answer.environments),
        [
            (row.label, *(entry_text(entry, answer.decimals) for entry in row.entries))
            for row in answer.rows
        ],
    )
    say(answer.definition.replace("Bold:", "Starred:"))


def entry_text(entry: StandingAnswer | None, decimals: int) -> str:
    """`0.731 ± 0.042 *`, the star for the best of its task; `(5 of 6)` where runs do not count."""
    if entry is None:
        return "-"
    counted = f" ({entry.n} of {entry.runs})" if entry.n < entry.runs else ""
    if entry.mean is None:
        return f"-{counted}"
    deviation = "" if entry.std is None else f" ± {entry.std:.{decimals}f}"
    return f"{entry.mean:.{decimals}f}{deviation}{' *' if entry.is_best else ''}{counted}"


def plot(
    sweep_id: SweepId,
    output: Annotated[Path, typer.Option("--output", "-o", help="A .png, .svg or .pdf file.")],
    figure: Annotated[
        FigureNumber | None,
        typer.Option(help="Number of a figure of the paper; every curve if unset."),
    ] = None,
    raw: Annotated[bool, typer.Option("--raw", help="Raw returns, not normalised.")] = False,
    as_json: AsJson = False,
) -> None:
    """Save the curves of a sweep, or one of the paper's figures of it, and its numbers as CSV."""
    form = form_of(output)
    if figure is not None and raw:
        raise typer.BadParameter(
            "the paper's figures have a fixed scale: leave --raw out", param_hint="--raw"
        )
    with Client() as client:
        picture = (
            client.figure(sweep_id, form, normalized=not raw)
            if figure is None
            else client.figure(sweep_id, form, figure)
        )
        numbers = (
            client.figure_data(sweep_id, normalized=not raw)
            if figure is None
            else client.figure_data(sweep_id, figure)
        )
    save_figure(output, picture, numbers, as_json)
