"""`d3pg cancel`, `pause`, `resume` and `retry`, of sweeps and of single runs."""

from __future__ import annotations

from collections.abc import Callable

from service.api.schemas.sweep_answer import SweepAnswer
from service.cli.following import counts_text
from service.cli.terminal import AsJson, Identifier, print_json, say
from service.client import Client
from service.model.move import TRANSITIONS, Move


def command_of(asked: Move) -> Callable[[str, bool], None]:
    """Return the command that asks for a move."""

    def command(identifier: Identifier, as_json: AsJson = False) -> None:
        move(identifier, asked, as_json)

    command.__name__ = asked
    command.__doc__ = TRANSITIONS[asked].help
    return command


def move(identifier: str, asked: Move, as_json: bool) -> None:
    """Ask for a move and print where that leaves things."""
    with Client() as client:
        answer = client.move(identifier, asked)
    if as_json:
        print_json(answer)
    elif isinstance(answer, SweepAnswer):
        say(f"{answer.id}: {answer.status} ({counts_text(answer)})")
    else:
        say(f"{answer.id}: {'cancelling' if answer.is_cancelling else answer.status}")
