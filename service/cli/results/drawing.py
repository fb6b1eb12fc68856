"""`d3pg figure`: the curves of a sweep as a figure for a paper, with the numbers in it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from service.analysis.comparison import Abscissa
from service.analysis.figures.design import FontFamily
from service.analysis.figures.figure_form import MEDIA_TYPES, Form
from service.cli.identifiers import SweepId
from service.cli.terminal import AsJson, say
from service.client import Client

Listed = list[str] | None
Drawn = Literal["std", "ci95", "iqr", "none"]


def figure(
    sweep_id: SweepId,
    output: Annotated[Path, typer.Option("--output", "-o", help="A .pdf, .svg or .png file.")],
    metric: Annotated[Listed, typer.Option(help="A row of panels each; else both returns.")] = None,
    environment: Annotated[Listed, typer.Option(help="Tasks, in this order; else all.")] = None,
    entry: Annotated[Listed, typer.Option(help="Labels, in this order; else all.")] = None,
    name: Annotated[Listed, typer.Option(help="LABEL=what the entry is called.")] = None,
    colour: Annotated[Listed, typer.Option(help="LABEL=#0072b2.")] = None,
    raw: Annotated[bool, typer.Option("--raw", help="Raw returns, not normalised.")] = False,
    band: Annotated[Drawn, typer.Option(help="Around the mean.")] = "std",
    seeds: Annotated[bool, typer.Option("--seeds", help="Each run's curve too, thin.")] = False,
    smoothing: Annotated[float, typer.Option(help="Weight of an exponential average.")] = 0.0,
    x: Annotated[Abscissa, typer.Option("--over", help="What the x axis is.")] = "timesteps",
    log_x: Annotated[bool, typer.Option("--log-x", help="A logarithmic x axis.")] = False,
    log_y: Annotated[bool, typer.Option("--log-y", help="A logarithmic y axis.")] = False,
    xmin: Annotated[float | None, typer.Option(help="Where the x axis begins.")] = None,
    xmax: Annotated[float | None, typer.Option(help="Where it ends.")] = None,
    ymin: Annotated[float | None, typer.Option(help="Where the y axis begins.")] = None,
    ymax: Annotated[float | None, typer.Option(help="Where it ends.")] = None,
    robust: Annotated[bool, typer.Option("--robust", help="Outliers do not set y.")] = False,
    align: Annotated[bool, typer.Option("--align", help="One y axis for a row.")] = False,
    per_row: Annotated[int | None, typer.Option(help="Panels in a row, of one metric.")] = None,
    columns: Annotated[int | None, typer.Option(help="Width: 1 or 2 columns of a paper.")] = None,
    width: Annotated[float | None, typer.Option(help="Width in inches.")] = None,
    height: Annotated[float | None, typer.Option(help="Height in inches.")] = None,
    font_size: Annotated[float, typer.Option(help="Points.")] = 8.0,
    font_family: Annotated[FontFamily, typer.Option(help="Of fonts.")] = "sans-serif",
    title: Annotated[bool, typer.Option(help="The sweep's name above.")] = True,
    caption: Annotated[bool, typer.Option(help="What is shown, in words below.")] = True,
    legend: Annotated[bool, typer.Option(help="Which line is whose.")] = True,
    as_json: AsJson = False,
) -> None:
    """Save curves of a sweep as a figure, and the numbers in it beside as CSV."""
    form = form_of(output)
    options: dict[str, Any] = {
        "metric": metric, "environment": environment, "entry": entry, "name": name,
        "colour": colour, "normalized": False if raw else None, "band": band, "seeds": seeds,
        "smoothing": smoothing, "x": x, "logx": log_x, "logy": log_y,
        "xmin": xmin, "xmax": xmax, "ymin": ymin, "ymax": ymax, "robust": robust, "align": align,
        "per_row": per_row, "columns": columns, "width": width, "height": height,
        "font_size": font_size, "font_family": font_family, "title": title, "caption": caption,
        "legend": legend,
    }  # fmt: skip
    asked = {option: value for option, value in options.items() if value is not None}
    with Client() as client:
        picture = client.figure(sweep_id, form, **asked)
        numbers = client.figure_data(sweep_id, **asked)
    save_figure(output, picture, numbers, as_json)


def save_figure(output: Path, picture: bytes, numbers: str, as_json: bool) -> None:
    """Write a figure, and its numbers beside it as CSV.

    Raises BadParameter, and writes nothing, where that would replace a CSV file of something else.
    """
    data = output.with_suffix(".csv")
    if data.exists() and not has_columns_of(data, numbers):
        raise typer.BadParameter(
            f"the numbers of the figure would replace {data}, which is of something else: name "
            "another file, or move that one away",
            param_hint="--output",
        )
    output.write_bytes(picture)
    data.write_text(numbers, encoding="utf-8", newline="")
    files = {"file": str(output), "data": str(data)}
    say(json.dumps(files) if as_json else f"Wrote {output} and {data}")


def has_columns_of(file: Path, numbers: str) -> bool:
    """Whether a CSV file begins as these numbers do: with the names of their columns."""
    names = numbers.partition("\n")[0].encode()
    with file.open("rb") as opened:
        return opened.read(len(names)) == names


def form_of(output: Path) -> Form:
    """The form that a file's name asks for. Raises BadParameter for another."""
    form = next((form for form in MEDIA_TYPES if output.suffix.lower() == f".{form}"), None)
    if form is None:
        raise typer.BadParameter(f"{output} must end in .png, .svg or .pdf", param_hint="--output")
    return form
