"""`d3pg db`: maintenance of the service's database."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from sqlalchemy import URL, Engine, make_url
from sqlalchemy.exc import SQLAlchemyError

from service.cli.terminal import AsJson, console, say
from service.data_dir import LOCK, held, make_private
from service.refusal import RefusalError
from service.settings import Settings
from service.store.connection import Role, connect
from service.store.refusal import TransferError
from service.store.upkeep import backup as backups
from service.store.upkeep import integrity, migration
from service.store.upkeep.transfer import transfer

app = typer.Typer(
    name="db",
    help="Upgrade, check, copy or back up the database.",
    no_args_is_help=True,
)
Database = Annotated[
    str | None,
    typer.Option("--database-url", help="SQLAlchemy URL of the database; the service's if unset."),
]
UPGRADING = "Upgrading the tables: some 10 s for each million measurements"
REFUSALS = (RefusalError, FileExistsError, FileNotFoundError, TransferError)


@app.command()
def upgrade(database_url: Database = None, as_json: AsJson = False) -> None:
    """Upgrade the tables to those of this version. The service does so when it starts."""
    url = _url(database_url)
    waiting = Console(stderr=True).status(UPGRADING)
    with _refusing(), _alone(url), _opened(url, "writer", is_new=True) as engine, waiting:
        migration.upgrade(engine)
    said = {"database": url.render_as_string(hide_password=True), "is_upgraded": True}
    say(json.dumps(said) if as_json else "The tables are those of this version.")


@app.command()
def check(database_url: Database = None, as_json: AsJson = False) -> None:
    """Check that the database is intact, even while the service runs; exit code 1 if it is not."""
    with _refusing(), _opened(_url(database_url), "reader") as engine:
        migration.refuse_outdated(engine)
        with engine.connect() as connection:
            checks = integrity.check(connection)
    if as_json:
        say(json.dumps([asdict(each) for each in checks]))
    else:
        _say_checks(checks)
    if any(each.faults for each in checks):
        raise typer.Exit(1)


def _say_checks(checks: Iterable[integrity.Check]) -> None:
    for each in checks:
        mark = "[red]broken[/]" if each.faults else "[green]holds [/]"
        console.print(f"{mark} {each.claim}", highlight=False)
        for fault in each.faults:
            say(f"       {fault}")


@app.command()
def copy(
    source: Annotated[
        str, typer.Argument(metavar="FROM_URL", help="Database to copy; stop its service first.")
    ],
    target: Annotated[
        str, typer.Argument(metavar="TO_URL", help="An empty database to copy into.")
    ],
    as_json: AsJson = False,
) -> None:
    """Copy everything into another database, and compare counts and hashes of every table."""
    with (
        _refusing(),
        _alone(source, target),
        _opened(source, "reader") as reader,
        _opened(source, "writer") as quiet,
        _opened(target, "writer", is_new=True) as writer,
    ):
        migration.refuse_outdated(reader)
        quiet.connect().close()  # its lock is held until the end: no service writes meanwhile
        migration.upgrade(writer)
        with _progress() as progress:
            tasks = {}

            def tell(table: str, rows: int, total: int) -> None:
                if table not in tasks:
                    tasks[table] = progress.add_task(table, total=total)
                progress.update(tasks[table], completed=rows)

            copied = transfer(reader, writer, tell)
    if as_json:
        say(json.dumps([asdict(table) for table in copied]))
        return
    for table in copied:
        say(f"{table.name:16} {table.rows:>10,} rows  sha256 {table.sha256}")
    say("Rows and hashes are equal at both ends.")


@app.command()
def backup(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write; it must not exist.")],
    database_url: Database = None,
    as_json: AsJson = False,
) -> None:
    """Write a backup of a SQLite database, even while the service runs."""
    url = _url(database_url)
    if url.get_backend_name() != "sqlite":
        raise typer.BadParameter(
            "this backs up SQLite alone: use pg_dump for PostgreSQL", param_hint="FILE"
        )
    with _refusing(), _opened(url, "reader") as engine:
        backups.backup(engine, file)
    say(json.dumps({"file": str(file)}) if as_json else f"Wrote {file}")


def _url(database_url: str | None) -> URL:
    return make_url(database_url) if database_url else Settings().store_url


@contextmanager
def _opened(url: str | URL, role: Role, *, is_new: bool = False) -> Iterator[Engine]:
    """Yield an engine. Raises FileNotFoundError instead of making a missing SQLite database."""
    file = _sqlite_file(url)
    if file is not None and not is_new and not file.exists():
        raise FileNotFoundError(f"there is no database {file}")
    engine = connect(url, role)
    try:
        yield engine
    finally:
        engine.dispose()


@contextmanager
def _alone(*urls: str | URL) -> Iterator[None]:
    """Hold the data directories of SQLite databases; a PostgreSQL writer is held anyway.

    A folder that no service has worked in is left as it is: it may be anybody's.
    """
    folders = {file.absolute().parent for url in urls if (file := _sqlite_file(url))}
    with ExitStack() as stack:
        for folder in folders:
            if not folder.exists():
                make_private(folder)
            if (folder / LOCK).exists():
                stack.enter_context(held(folder))
        yield


def _sqlite_file(url: str | URL) -> Path | None:
    address = make_url(url)
    is_file = address.get_backend_name() == "sqlite" and address.database
    return Path(str(address.database)) if is_file else None


def _progress() -> Progress:
    columns = (TextColumn("{task.description:16}"), BarColumn(), MofNCompleteColumn())
    return Progress(*columns, console=Console(stderr=True), transient=True)


@contextmanager
def _refusing() -> Iterator[None]:
    """Say what is wrong in a sentence and exit with code 1."""
    try:
        yield
    except (*REFUSALS, SQLAlchemyError) as error:
        said = getattr(error, "orig", None) or error
        Console(stderr=True).print(str(said).strip(), style="red", markup=False, soft_wrap=True)
        raise typer.Exit(1) from error
