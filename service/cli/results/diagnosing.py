"""`d3pg diagnose`: where gradients help a run or a sweep, as tables, as CSV and as figures."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from algorithms.cli.findings import tables_of
from service.analysis.diagnosis import FigureName
from service.analysis.figures.figure_form import MEDIA_TYPES
from service.api.schemas.diagnosis_answer import MAX_SEEDS, DiagnosisAnswer
from service.api.schemas.score_table_answer import inert
from service.cli.identifiers import Identifier
from service.cli.terminal import AsJson, console, print_json, say
from service.client import Client
from service.model.run_name import is_run

COLUMNS = (
    "label", "environment", "seeds", "diagnostic", "quantity", "horizon", "noise", "value",
)  # fmt: skip


def diagnose(
    identifier: Identifier,
    seeds: Annotated[
        int | None,
        typer.Option(
            min=1, max=MAX_SEEDS, help="Seeds of each cell of a sweep, at most; 4 if unset."
        ),
    ] = None,
    environment: Annotated[
        str | None, typer.Option(metavar="TASK", help="Only this task of a sweep.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="File to write: .csv; with --figure .png, .svg or .pdf."
        ),
    ] = None,
    figure: Annotated[FigureName | None, typer.Option(help="The figure to save.")] = None,
    as_json: AsJson = False,
) -> None:
    """Show where the simulator's gradients help a run or a sweep, and where they cannot.

    The service finds it once, from what each run has learned at its end. The numbers of a sweep are
    medians over the first seeds of each cell that reached their end.
    """
    options = options_of(identifier, seeds, environment)
    refuse_output(output, figure)
    with Client() as client:
        found = client.diagnose(identifier, progressed=telling(), **options)
        if output is not None:
            output.write_bytes(content(client, identifier, found, output, figure, options))
    if as_json:
        print_json(found)
    else:
        show(found, output)
    if not found.done:
        raise typer.Exit(1)


def options_of(identifier: str, seeds: int | None, environment: str | None) -> dict[str, Any]:
    """Return the query options. Raises typer.BadParameter for a run, which takes none."""
    asked: dict[str, int | str | None] = {"seeds": seeds, "environment": environment}
    options = {name: value for name, value in asked.items() if value is not None}
    if options and is_run(identifier):
        raise typer.BadParameter(
            f"{identifier} is a run: --seeds and --environment are for sweeps alone",
            param_hint="ID",
        )
    return options


def refuse_output(output: Path | None, figure: FigureName | None) -> None:
    """Raise typer.BadParameter for a file that cannot be written in its form."""
    if figure is None:
        if output is not None and output.suffix.lower() != ".csv":
            raise typer.BadParameter(
                f"{output} must end in .csv, or name a figure with --figure", param_hint="--output"
            )
    elif output is None or output.suffix.lower().removeprefix(".") not in MEDIA_TYPES:
        raise typer.BadParameter(
            "--figure needs an output file that ends in .png, .svg or .pdf", param_hint="--output"
        )


def telling() -> Callable[[DiagnosisAnswer], None]:
    """Return a callback that prints progress on standard error when there is some."""
    told = -1

    def tell(diagnosis: DiagnosisAnswer) -> None:
        nonlocal told
        ended = diagnosis.done + diagnosis.failed
        if ended > told:
            told = ended
            typer.echo(f"{ended} of {diagnosis.runs} runs are diagnosed", err=True)

    return tell


def content(
    client: Client,
    identifier: str,
    found: DiagnosisAnswer,
    output: Path,
    figure: FigureName | None,
    options: dict[str, Any],
) -> bytes:
    """The bytes of the file: a figure, or every number as CSV."""
    if figure is None:
        return csv_of(found).encode()
    form = next(form for form in MEDIA_TYPES if output.suffix.lower() == f".{form}")
    return client.diagnosis_figure(identifier, figure, form, **options)


def csv_of(found: DiagnosisAnswer) -> str:
    """Every number as CSV (RFC 4180); a cell is empty where it does not apply or exist."""
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(COLUMNS)
    for cell in found.cells:
        name = (inert(cell.label), inert(cell.environment), " ".join(map(str, cell.seeds)))
        writer.writerows((*name, *each.model_dump().values()) for each in cell.findings)
    return file.getvalue()


def show(found: DiagnosisAnswer, output: Path | None) -> None:
    """Print the tables of each cell, or the file they are in, then remarks and problems."""
    if output is not None:
        say(f"Wrote {output}")
    for cell in () if output else found.cells:
        say(f"{cell.label} in {cell.environment}, seeds {', '.join(map(str, cell.seeds))}\n")
        for heading, table in tables_of(cell.medians):
            say(heading)
            console.print(table)
    for sentence in (*found.remarks, *found.problems):
        say(sentence)
