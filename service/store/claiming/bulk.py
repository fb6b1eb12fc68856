"""Many moves as one: each is made, or refused with a reason; a refusal stops no other."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from sqlalchemy import Connection

from service.model.move import TRANSITIONS, Move
from service.model.run_name import is_run
from service.store.claiming.deletion import delete_sweep
from service.store.claiming.run_moves import move_run
from service.store.claiming.sweep_edits import edit
from service.store.claiming.sweep_moves import move_sweep
from service.store.refusal import ImpossibleMoveError, NotFoundError

BulkMove = Literal[Move, "delete", "archive", "unarchive"]

MOVES: Mapping[str, Move] = {move: move for move in TRANSITIONS}
OF_SWEEPS: Mapping[str, Callable[[Connection, str], object]] = {
    "delete": delete_sweep,
    "archive": lambda connection, name: edit(connection, name, {"archived": True}),
    "unarchive": lambda connection, name: edit(connection, name, {"archived": False}),
}


@dataclass(frozen=True)
class Refusal:
    """Why one of them could not be moved."""

    id: str
    reason: str


def move_all(connection: Connection, asked: BulkMove, identifiers: Sequence[str]) -> list[Refusal]:
    """Move sweeps and runs; return those that were refused."""
    refused = []
    for identifier in identifiers:
        try:
            _move(connection, asked, identifier)
        except (ImpossibleMoveError, NotFoundError) as refusal:
            refused.append(Refusal(identifier, str(refusal)))
    return refused


def _move(connection: Connection, asked: BulkMove, identifier: str) -> None:
    of_sweep = OF_SWEEPS.get(asked)
    if of_sweep is None:
        move = move_run if is_run(identifier) else move_sweep
        move(connection, identifier, MOVES[asked])
    elif is_run(identifier):
        raise ImpossibleMoveError(f"{identifier} is a run: only sweeps have the move {asked}")
    else:
        of_sweep(connection, identifier)
