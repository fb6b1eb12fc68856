"""The commands of `d3pg`, each in the file of its kind.

Exit codes: 0 done; 1 the service refused, a check failed, or a run of the watched sweep failed; 2
the command was called wrongly; 130 interrupted. Those of `ask` are answers; its failures have the
codes of `service.cli.answering`.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from typing import Annotated

import typer
from rich.console import Console

from service.cli import paper
from service.cli.adding import add, extend
from service.cli.answering import AnsweringCommand
from service.cli.asking import ask
from service.cli.editing import edit, rm
from service.cli.following import watch
from service.cli.host import db, demo
from service.cli.host.doctor import doctor
from service.cli.host.serving import serve
from service.cli.listing import ls, show
from service.cli.moving import command_of
from service.cli.people import sessions, shares, users
from service.cli.people.sessions import signin
from service.cli.people.shares import share
from service.cli.results.diagnosing import diagnose
from service.cli.results.drawing import figure
from service.cli.results.exporting import export, plot, table
from service.cli.results.logs import logs
from service.cli.results.policies import policy
from service.cli.results.rolling import rollout
from service.cli.results.verifying import verify
from service.cli.searching import search
from service.cli.submitting import submit
from service.cli.terminal import AsJson, say
from service.client import ServiceError, find_token
from service.model.move import TRANSITIONS

app = typer.Typer(
    name="d3pg",
    help="Sweeps of learning control with differentiable physics.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
app.add_typer(db.app)
app.add_typer(users.app)
app.add_typer(shares.app)
app.add_typer(sessions.app)
app.add_typer(paper.app)
COMMANDS: tuple[Callable[..., None], ...] = (
    serve, submit, search, ls, show, logs, edit, watch, *map(command_of, TRANSITIONS), rm, add,
    extend, export, table, plot, figure, rollout, policy, diagnose, verify, share, signin,
    doctor,
)  # fmt: skip
for command in COMMANDS:
    app.command()(command)
app.command(cls=AnsweringCommand)(ask)


@app.command()
def token(
    header: Annotated[
        bool,
        typer.Option("--header", help="Print it as a header, for curl -H @<(d3pg token --header)."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the token that commands here use, for `Authorization: Bearer`."""
    found = find_token()
    shown = f"Authorization: Bearer {found}" if header else found
    say(json.dumps({"token": found}) if as_json else shown)


@app.command(name="demo")
def run_demo(
    once: Annotated[bool, typer.Option("--once", help="Exit when the sweep has ended.")] = False,
    as_json: AsJson = False,
) -> None:
    """Start the service, train a small sweep for real and show its curves; until Ctrl-C.

    With --json: print a line with the sweep's id and the link, then one for each change.
    """
    raise typer.Exit(demo.run(once=once, as_json=as_json))


def main() -> None:
    """Run the command line; a refusal is a sentence and exit code 1, not a traceback."""
    try:
        app()
    except (ServiceError, OSError) as error:
        if isinstance(error, BrokenPipeError):  # the reader of our output has closed it
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        else:
            say(str(error), Console(stderr=True, style="red"))
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
