"""`d3pg share` and `d3pg shares`: links that let others read sweeps for a time."""

from __future__ import annotations

from typing import Annotated

import typer
from pydantic import RootModel

from service.api.schemas.people import DAYS, MAX_DAYS, ShareAnswer
from service.cli.identifiers import SweepIds
from service.cli.terminal import AsJson, errors, print_json, print_table, say
from service.client import Client

app = typer.Typer(name="shares", help="Links by which others read sweeps: list, revoke.")


def share(
    sweep_ids: SweepIds,
    days: Annotated[
        int, typer.Option(min=1, max=MAX_DAYS, help="Days until the link expires.")
    ] = DAYS,
    as_json: AsJson = False,
) -> None:
    """Make a link by which anybody can read a sweep, or a comparison of several, for some days."""
    with Client() as client:
        made = client.share(sweep_ids, days=days)
    if as_json:
        print_json(made)
        return
    say(made.link)
    say(
        f"Anybody with this link can read {', '.join(made.sweeps)} until "
        f"{made.expires_at:%Y-%m-%d %H:%M} UTC. To revoke it: d3pg shares revoke {made.id}",
        errors,
    )


@app.callback(invoke_without_command=True)
def shares(context: typer.Context, as_json: AsJson = False) -> None:
    """List your shares (an administrator: those of all users), or revoke one."""
    if context.invoked_subcommand is not None:
        return
    with Client() as client:
        found = client.shares()
    if as_json:
        print_json(RootModel[list[ShareAnswer]](found))
        return
    print_table(
        ("share", "sweeps", "made by", "expires (UTC)"),
        [
            (each.id, ", ".join(each.sweeps), each.made_by, f"{each.expires_at:%Y-%m-%d %H:%M}")
            for each in found
        ],
    )


@app.command()
def revoke(
    share_id: Annotated[
        str, typer.Argument(metavar="SHARE", help="Id of the share, from the list.")
    ],
    as_json: AsJson = False,
) -> None:
    """Revoke a share at once."""
    with Client() as client:
        revoked = client.revoke_share(share_id)
    if as_json:
        print_json(revoked)
    else:
        say(f"Share {revoked.id} was revoked.")
