"""A sweep as files for other tools: what `d3pg export --format` writes, except CSV."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import typer

from service.client import Client, ServiceError
from service.export import arrays

Format = Literal[
    "csv", "parquet", "tensorboard", "wandb", "mlflow", "openrlbenchmark", "rliable", "report"
]
SUFFIXES: Mapping[str, Format] = {".parquet": "parquet", ".html": "report"}
"""The form of a file by its suffix, if no form is named."""
Written = dict[str, Any]
"""What was written, and where."""


@dataclass(frozen=True)
class Converter:
    """How a form is written.

    write      (client, sweep, output) -> how much
    opened     how to open it, with the output in place of {}
    is_folder  whether it writes a folder of files of its own
    """

    write: Callable[[Client, str, Path], Written]
    opened: str
    is_folder: bool = False


def convert(form: Format, client: Client, sweep_id: str, output: Path) -> tuple[Written, str]:
    """Write a sweep, and return what was written and how to open it.

    Raises typer.BadParameter for a folder that has files, ServiceError where an extra is missing.
    """
    converter = CONVERTERS[form]
    if converter.is_folder and output.exists() and (not output.is_dir() or any(output.iterdir())):
        raise typer.BadParameter(
            f"{output} exists already: name a new folder", param_hint="--output"
        )
    try:
        written = converter.write(client, sweep_id, output)
    except (ModuleNotFoundError, ValueError) as error:
        raise ServiceError(f"{form}: {error}") from error
    return {**written, "output": str(output)}, converter.opened.format(output)


def _runs(module: str) -> Callable[[Client, str, Path], Written]:
    """Return what writes runs one by one, by a module of `service.export`."""

    def write(client: Client, sweep_id: str, output: Path) -> Written:
        sweep = client.sweep(sweep_id)
        written = import_module(f"service.export.{module}").write
        name = f"{sweep.name} ({sweep.id})"
        return {"runs": written(client.measured_runs(sweep_id), output, name)}

    return write


def _parquet(client: Client, sweep_id: str, output: Path) -> Written:
    return {"bytes": client.save_measurements(sweep_id, output, "parquet")}


def _report(client: Client, sweep_id: str, output: Path) -> Written:
    return {"bytes": output.write_bytes(client.report(sweep_id).encode())}


def _openrlbenchmark(client: Client, sweep_id: str, output: Path) -> Written:
    return _saved(arrays.openrlbenchmark(client.measured_runs(sweep_id)), output)


def _rliable(client: Client, sweep_id: str, output: Path) -> Written:
    return _saved(arrays.rliable(client.scores(sweep_id)), output)


def _saved(made: arrays.Arrays, output: Path) -> Written:
    arrays.write(made, output)
    return {"arrays": len(made)}


CONVERTERS: Mapping[Format, Converter] = {
    "parquet": Converter(_parquet, "pandas.read_parquet('{}') reads it"),
    "tensorboard": Converter(
        _runs("tensorboard_events"), "tensorboard --logdir '{}' shows them", is_folder=True
    ),
    "wandb": Converter(
        _runs("wandb_runs"), "wandb sync '{}'/wandb/offline-run-* uploads them", is_folder=True
    ),
    "mlflow": Converter(
        _runs("mlflow_runs"), "mlflow ui --backend-store-uri sqlite:///{} shows them"
    ),
    "openrlbenchmark": Converter(_openrlbenchmark, "numpy.load('{}') reads them"),
    "report": Converter(_report, "a browser opens it, without the service"),
    "rliable": Converter(_rliable, "numpy.load('{}') reads them"),
}
