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
    metric: Annotated[
        Listed, typer.Option(help="Metric, a row of panels each; both returns if unset.")
    ] = None,
    environment: Annotated[
        Listed, typer.Option(help="Tasks to draw, in this order; all if unset.")
    ] = None,
    entry: Annotated[
        Listed, typer.Option(help="Labels of entries to draw, in this order; all if unset.")
    ] = None,
    name: Annotated[
        Listed, typer.Option(help="LABEL=NAME: name of an entry in the figure.")
    ] = None,
    colour: Annotated[Listed, typer.Option(help="LABEL=COLOUR, such as ddpg=#0072b2.")] = None,
    raw: Annotated[bool, typer.Option("--raw", help="Raw returns, not normalised.")] = False,
    band: Annotated[Drawn, typer.Option(help="Band around the mean.")] = "std",
    seeds: Annotated[
        bool, typer.Option("--seeds", help="Draw each run's curve too, as a thin line.")
    ] = False,
    smoothing: Annotated[float, typer.Option(help="Weight of an exponential average.")] = 0.0,
    x: Annotated[Abscissa, typer.Option("--over", help="Quantity of the x axis.")] = "timesteps",
    log_x: Annotated[bool, typer.Option("--log-x", help="A logarithmic x axis.")] = False,
    log_y: Annotated[bool, typer.Option("--log-y", help="A logarithmic y axis.")] = False,
    xmin: Annotated[float | None, typer.Option(help="Where the x axis begins.")] = None,
    xmax: Annotated[float | None, typer.Option(help="Where the x axis ends.")] = None,
    ymin: Annotated[float | None, typer.Option(help="Where the y axis begins.")] = None,
    ymax: Annotated[float | None, typer.Option(help="Where the y axis ends.")] = None,
    robust: Annotated[
        bool, typer.Option("--robust", help="Leave outliers out of the y range.")
    ] = False,
    align: Annotated[bool, typer.Option("--align", help="Same y axis for a row.")] = False,
    per_row: Annotated[
        int | None, typer.Option(help="Panels in a row, for a single metric.")
    ] = None,
    columns: Annotated[int | None, typer.Option(help="Width: 1 or 2 columns of a paper.")] = None,
    width: Annotated[float | None, typer.Option(help="Width in inches.")] = None,
    height: Annotated[float | None, typer.Option(help="Height in inches.")] = None,
    font_size: Annotated[float, typer.Option(help="Size of the font in points.")] = 8.0,
    font_family: Annotated[FontFamily, typer.Option(help="Family of the font.")] = "sans-serif",
    title: Annotated[bool, typer.Option(help="Show the name of the sweep above.")] = True,
    caption: Annotated[bool, typer.Option(help="Describe in words below what is shown.")] = True,
    legend: Annotated[bool, typer.Option(help="Show the legend.")] = True,
    as_json: AsJson = False,
) -> None:
    """Save curves of a sweep as a figure, and its numbers beside it as CSV."""
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

    Raises BadParameter and writes nothing if that would replace a CSV file with other columns.
    """
    data = output.with_suffix(".csv")
    if data.exists() and not has_columns_of(data, numbers):
        raise typer.BadParameter(
            f"the numbers of the figure would replace {data}, which has other columns: name "
            "another output file, or move that file away",
            param_hint="--output",
        )
    output.write_bytes(picture)
    data.write_text(numbers, encoding="utf-8", newline="")
    files = {"file": str(output), "data": str(data)}
    say(json.dumps(files) if as_json else f"Wrote {output} and {data}")


def has_columns_of(file: Path, numbers: str) -> bool:
    """Whether a CSV file begins with the column names of these numbers."""
    names = numbers.partition("\n")[0].encode()
    with file.open("rb") as opened:
        return opened.read(len(names)) == names


def form_of(output: Path) -> Form:
    """The form of a file by its suffix. Raises BadParameter for an unknown one."""
    form = next((form for form in MEDIA_TYPES if output.suffix.lower() == f".{form}"), None)
    if form is None:
        raise typer.BadParameter(f"{output} must end in .png, .svg or .pdf", param_hint="--output")
    return form
