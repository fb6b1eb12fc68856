"""Patience: asking a place again that does not answer."""

from collections.abc import Callable
from typing import TypeVar

from workers.checkpoints.folder import UnreachableError

Patience = Callable[[], bool]
"""Waits a little, and says whether to ask once more."""
T = TypeVar("T")


def without_patience() -> bool:
    """Ask once only."""
    return False


def answered(ask: Callable[[], T], patience: Patience) -> T:
    """What it answers in the end. Raises UnreachableError when there is no patience left."""
    while True:
        try:
            return ask()
        except UnreachableError:
            if not patience():
                raise
