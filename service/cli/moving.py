"""`d3pg cancel`, `pause`, `resume` and `retry`, of sweeps and of single runs."""

from __future__ import annotations

from collections.abc import Callable

import typer

from service.api.schemas.requests.bulk import BulkAnswer
from service.api.schemas.sweep_answer import SweepAnswer
from service.cli.following import counts_text
from service.cli.identifiers import Identifiers
from service.cli.terminal import AsJson, errors, print_json, say
from service.client import Client
from service.model.move import TRANSITIONS, Move


def command_of(asked: Move) -> Callable[[list[str], bool], None]:
    """Return the command that asks for a move."""

    def command(identifiers: Identifiers, as_json: AsJson = False) -> None:
        move(identifiers, asked, as_json)

    command.__name__ = asked
    command.__doc__ = TRANSITIONS[asked].help
    return command


def move(identifiers: list[str], asked: Move, as_json: bool) -> None:
    """Ask for a move, in one request for all ids, and print the new status."""
    with Client() as client:
        if len(identifiers) > 1:
            say_moved(client.move_all(identifiers, asked), TRANSITIONS[asked].change, as_json)
            return
        answer = client.move(identifiers[0], asked)
    if as_json:
        print_json(answer)
    elif isinstance(answer, SweepAnswer):
        say(f"{answer.id}: {answer.status} ({counts_text(answer)})")
    else:
        say(f"{answer.id}: {'cancelling' if answer.is_cancelling else answer.status}")


def say_moved(answer: BulkAnswer, change: str, as_json: bool) -> None:
    """Print what was moved, and on standard error what was not; exit with 1 where there is some."""
    if as_json:
        print_json(answer)
    else:
        for moved in answer.moved:
            say(f"{moved}: {change}")
        for each in answer.refused:
            say(f"{each.id}: {each.reason}", errors)
    if answer.refused:
        raise typer.Exit(1)
