"""The commands of `d3pg`.

Exit codes: 0 done; 1 the service refused or a run of the watched sweep failed; 2 the command
was called wrongly; 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
import yaml
from rich.console import Console

from service.cli import db, demo
from service.cli.following import follow
from service.client import Client, ServiceError, find_token

app = typer.Typer(
    name="d3pg",
    help="Sweeps of learning control with differentiable physics.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
app.add_typer(db.app)
console = Console()

SERVE_FLAGS = {
    "host": "D3PG_HOST",
    "port": "D3PG_PORT",
    "data_dir": "D3PG_DATA_DIR",
    "database_url": "D3PG_DATABASE_URL",
    "ray_address": "D3PG_RAY_ADDRESS",
    "workers": "D3PG_WORKERS",
    "token": "D3PG_TOKEN",
    "allow_host": "D3PG_ALLOW_HOST",
}

SweepId = Annotated[str, typer.Argument(metavar="SWEEP", help="The id of a sweep.")]


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to bind; 127.0.0.1 if unset.")] = None,
    port: Annotated[int | None, typer.Option(help="Port; 8000 if unset.")] = None,
    data_dir: Annotated[Path | None, typer.Option(help="Database, token, logs.")] = None,
    database_url: Annotated[str | None, typer.Option(help="Another database.")] = None,
    ray_address: Annotated[str | None, typer.Option(help="A Ray cluster to join.")] = None,
    workers: Annotated[int | None, typer.Option(help="Local worker slots; the cores.")] = None,
    token: Annotated[str | None, typer.Option(help="Instead of the token file's.")] = None,
    allow_host: Annotated[str | None, typer.Option(help="Host names to answer to.")] = None,
) -> None:
    """Run the service here, until Ctrl-C. Each option is also an environment variable."""
    given = {name: value for name, value in locals().items() if value is not None}
    variables = {SERVE_FLAGS[name]: str(value) for name, value in given.items()}
    os.execve(sys.executable, [sys.executable, "-m", "service"], os.environ | variables)  # noqa: S606


@app.command()
def submit(
    file: Annotated[Path, typer.Argument(metavar="FILE.yaml", help="The sweep; - reads stdin.")],
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only count the runs.")] = False,
    watch: Annotated[bool, typer.Option("--watch", help="Then follow it to its end.")] = False,
) -> None:
    """Queue a sweep described in a YAML file."""
    request = read_request(file)
    with Client() as client:
        if dry_run:
            console.print(f"{client.count(request)['runs']['total']} runs; nothing was queued.")
            return
        sweep = client.submit(request)
        console.print(f"Sweep {sweep['id']}: {sweep['runs']['total']} runs queued.")
        console.print(f"{client.url}/sweeps/{sweep['id']}", soft_wrap=True)
        if watch:
            raise typer.Exit(follow(client, sweep["id"], console))


@app.command()
def watch(sweep_id: SweepId) -> None:
    """Follow a sweep to its end: progress, ETA, where its curves stand."""
    with Client() as client:
        raise typer.Exit(follow(client, sweep_id, console))


@app.command()
def cancel(
    identifier: Annotated[str, typer.Argument(metavar="ID", help="A sweep or a single run.")],
) -> None:
    """Cancel a sweep or one run; what it measured so far stays."""
    with Client() as client:
        answer = client.cancel(identifier)
    console.print(f"{answer['id']}: {answer['status']}")


@app.command()
def plot(
    sweep_id: SweepId,
    output: Annotated[Path, typer.Option("--output", "-o", help="A .png, .svg or .pdf file.")],
    raw: Annotated[bool, typer.Option("--raw", help="Raw returns, not normalised.")] = False,
) -> None:
    """Save the comparison figure of a sweep."""
    form = output.suffix.removeprefix(".")
    if form not in ("png", "svg", "pdf"):
        raise typer.BadParameter(f"{output} must end in .png, .svg or .pdf", param_hint="--output")
    with Client() as client:
        output.write_bytes(client.plot(sweep_id, form, normalized=not raw))  # type: ignore[arg-type]
    console.print(f"Wrote {output}")


@app.command()
def token() -> None:
    """Print the service's token, for `Authorization: Bearer`."""
    console.print(find_token(), markup=False, highlight=False)


@app.command(name="demo")
def run_demo(
    once: Annotated[bool, typer.Option("--once", help="End with the sweep.")] = False,
) -> None:
    """Start the service, train a small sweep for real and show its curves; until Ctrl-C."""
    raise typer.Exit(demo.run(console, once))


def read_request(file: Path) -> dict[str, Any]:
    """The sweep in a YAML file; raises typer.BadParameter with what is wrong with it."""
    try:
        text = sys.stdin.read() if str(file) == "-" else file.read_text(encoding="utf-8")
        request = yaml.safe_load(text)
    except OSError as error:
        raise typer.BadParameter(f"cannot read {file}: {error.strerror}") from error
    except yaml.YAMLError as error:
        raise typer.BadParameter(f"{file} is not YAML: {error}") from error
    if not isinstance(request, dict):
        raise typer.BadParameter(
            f"{file} must hold a mapping with the keys algorithms, environments, seeds and "
            f"timesteps, not a {type(request).__name__}"
        )
    return request


def main() -> None:
    """Run the command line; a refusal is a sentence and exit code 1, not a traceback."""
    try:
        app()
    except ServiceError as error:
        Console(stderr=True).print(str(error), style="red", markup=False)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
