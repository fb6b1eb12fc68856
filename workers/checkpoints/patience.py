"""Patience: repeated requests to a place that does not answer."""

from collections.abc import Callable
from typing import TypeVar

from workers.checkpoints.folder import UnreachableError

Patience = Callable[[], bool]
"""Waits a little, and returns whether to try once more."""
T = TypeVar("T")


def without_patience() -> bool:
    """Try only once."""
    return False


def answered(ask: Callable[[], T], patience: Patience) -> T:
    """Return the answer. Raises UnreachableError when there is no patience left."""
    while True:
        try:
            return ask()
        except UnreachableError:
            if not patience():
                raise
