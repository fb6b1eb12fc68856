"""`d3pg signin` and `d3pg sessions`: browsers that are signed in."""

from __future__ import annotations

from typing import Annotated

import typer
from pydantic import RootModel

from service.api.schemas.people import SessionAnswer
from service.cli.identifiers import complete_sweep, whole_id
from service.cli.terminal import AsJson, errors, print_json, print_table, say
from service.client import Client

app = typer.Typer(name="sessions", help="Browsers that are signed in: list, end.")


def signin(
    sweep_id: Annotated[
        str | None,
        typer.Argument(
            metavar="[SWEEP]",
            help="Sweep whose page the link opens.",
            autocompletion=complete_sweep,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print a link that signs one browser in as you, within ten minutes."""
    page = "/" if sweep_id is None else f"/sweeps/{whole_id(sweep_id)}"
    with Client() as client:
        answer = client.sign_in_link(page)
    if as_json:
        print_json(answer)
        return
    say(answer.link)
    say(f"It signs one browser in, within {answer.seconds // 60} minutes.", errors)


@app.callback(invoke_without_command=True)
def sessions(context: typer.Context, as_json: AsJson = False) -> None:
    """List your signed-in browsers (an administrator: those of all users), or sign one out."""
    if context.invoked_subcommand is not None:
        return
    with Client() as client:
        found = client.sessions()
    if as_json:
        print_json(RootModel[list[SessionAnswer]](found))
        return
    print_table(
        ("session", "user", "since (UTC)", "until (UTC)", "browser"),
        [
            (
                each.id,
                each.name,
                f"{each.created_at:%Y-%m-%d %H:%M}",
                f"{each.expires_at:%Y-%m-%d %H:%M}",
                each.browser,
            )
            for each in found
        ],
    )


@app.command()
def end(
    session_id: Annotated[
        str, typer.Argument(metavar="SESSION", help="Id of the session, from the list.")
    ],
    as_json: AsJson = False,
) -> None:
    """Sign a browser out at once."""
    with Client() as client:
        ended = client.end_session(session_id)
    if as_json:
        print_json(ended)
    else:
        say(f"Session {ended.id} was ended.")
