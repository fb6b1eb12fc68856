"""`d3pg users`: who has a token, and for what."""

from __future__ import annotations

from typing import Annotated

import typer
from pydantic import RootModel

from service.api.schemas.people import UserAnswer
from service.cli.terminal import AsJson, errors, print_json, print_table, say
from service.client import Client
from service.model.caller import Scope

app = typer.Typer(
    name="users", help="Users with a token of their own: list, add, revoke.", no_args_is_help=False
)
UserName = Annotated[str, typer.Argument(metavar="NAME", help="Name of the user.")]


@app.callback(invoke_without_command=True)
def users(context: typer.Context, as_json: AsJson = False) -> None:
    """List users, revoked ones included; add or revoke one."""
    if context.invoked_subcommand is not None:
        return
    with Client() as client:
        found = client.users()
    if as_json:
        print_json(RootModel[list[UserAnswer]](found))
        return
    print_table(
        ("user", "scope", "since (UTC)", "revoked (UTC)"),
        [
            (
                user.name,
                user.scope.value,
                f"{user.created_at:%Y-%m-%d %H:%M}",
                "" if user.revoked_at is None else f"{user.revoked_at:%Y-%m-%d %H:%M}",
            )
            for user in found
        ],
    )


@app.command()
def add(
    name: UserName,
    scope: Annotated[
        Scope,
        typer.Option(
            help="metrics: /metrics alone; read: everything; submit: also own sweeps; admin: all."
        ),
    ],
    as_json: AsJson = False,
) -> None:
    """Add a user and print the token, once. A revoked user gets a new token."""
    with Client() as client:
        user = client.add_user(name, scope)
    if as_json:
        print_json(user)
        return
    say(user.token)
    say(
        f"This is the token of {user.name} ({user.scope.value}), shown only once. Write it into "
        "a file of mode 600 that D3PG_TOKEN_FILE names, or paste it into the sign-in page.",
        errors,
    )


@app.command()
def revoke(name: UserName, as_json: AsJson = False) -> None:
    """Revoke a user at once: token, sessions and shares. The sweeps of the user stay."""
    with Client() as client:
        user = client.revoke_user(name)
    if as_json:
        print_json(user)
    else:
        say(f"{user.name} was revoked.")
