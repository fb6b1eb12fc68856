"""`d3pg serve`: the service itself."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

SERVE_FLAGS = {
    "host": "D3PG_HOST",
    "port": "D3PG_PORT",
    "data_dir": "D3PG_DATA_DIR",
    "checkpoints": "D3PG_CHECKPOINTS",
    "database_url": "D3PG_DATABASE_URL",
    "ray_address": "D3PG_RAY_ADDRESS",
    "workers": "D3PG_WORKERS",
    "min_workers": "D3PG_MIN_WORKERS",
    "max_workers": "D3PG_MAX_WORKERS",
    "worker_memory": "D3PG_WORKER_MEMORY",
    "token": "D3PG_TOKEN",
    "allow_host": "D3PG_ALLOW_HOST",
}


def serve(
    host: Annotated[str | None, typer.Option(help="Address to bind; 127.0.0.1 if unset.")] = None,
    port: Annotated[int | None, typer.Option(help="Port; 8000 if unset.")] = None,
    data_dir: Annotated[Path | None, typer.Option(help="Database, token, logs.")] = None,
    checkpoints: Annotated[
        str | None, typer.Option(help="Another folder for them, or s3://bucket/prefix.")
    ] = None,
    database_url: Annotated[str | None, typer.Option(help="Another database.")] = None,
    ray_address: Annotated[str | None, typer.Option(help="A Ray cluster to join.")] = None,
    workers: Annotated[int | None, typer.Option(help="Local worker slots; the cores.")] = None,
    min_workers: Annotated[
        int | None, typer.Option(help="Kept on a joined cluster, however idle; 1.")
    ] = None,
    max_workers: Annotated[int | None, typer.Option(help="Most on a joined cluster; 1024.")] = None,
    worker_memory: Annotated[
        str | None, typer.Option(help="What the runs of one may fill, such as 6GB.")
    ] = None,
    token: Annotated[str | None, typer.Option(help="Instead of the token file's.")] = None,
    allow_host: Annotated[str | None, typer.Option(help="Host names to answer to.")] = None,
) -> None:
    """Run the service here, until Ctrl-C. Each option is also an environment variable."""
    given = {name: value for name, value in locals().items() if value is not None}
    variables = {SERVE_FLAGS[name]: str(value) for name, value in given.items()}
    os.execve(sys.executable, [sys.executable, "-m", "service"], os.environ | variables)  # noqa: S606
