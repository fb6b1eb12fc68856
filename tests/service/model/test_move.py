"""The table of moves: where they lead, and that every one of them can be asked for."""

from typing import get_args

import pytest

from service.model.move import TRANSITIONS, Move
from service.model.run import FINAL, RunStatus


def test_every_move_is_in_the_table() -> None:
    assert tuple(TRANSITIONS) == get_args(Move)


@pytest.mark.parametrize("asked", TRANSITIONS)
def test_a_move_leaves_no_end_but_failures_and_cancellations(asked: Move) -> None:
    transition = TRANSITIONS[asked]
    assert transition.sources & FINAL <= {RunStatus.FAILED, RunStatus.CANCELLED}
    assert transition.target not in transition.sources
    assert RunStatus.RUNNING not in transition.sources  # a worker holds it
