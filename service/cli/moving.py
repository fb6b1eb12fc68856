"""`d3pg cancel`, `pause`, `resume` and `retry`, of sweeps and of single runs."""

from __future__ import annotations

from service.api.schemas.sweep_answer import SweepAnswer
from service.cli.following import counts_text
from service.cli.terminal import AsJson, Identifier, print_json, say
from service.client import Client, Move


def cancel(identifier: Identifier, as_json: AsJson = False) -> None:
    """Cancel a sweep or one run; what it measured so far stays."""
    move(identifier, "cancel", as_json)


def pause(identifier: Identifier, as_json: AsJson = False) -> None:
    """Start none of the queued runs; those that are running go on to their end."""
    move(identifier, "pause", as_json)


def resume(identifier: Identifier, as_json: AsJson = False) -> None:
    """Queue what was paused."""
    move(identifier, "resume", as_json)


def retry(identifier: Identifier, as_json: AsJson = False) -> None:
    """Queue failed runs again, and only those; what they measured stays."""
    move(identifier, "retry", as_json)


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
