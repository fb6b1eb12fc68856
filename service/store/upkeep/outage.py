"""Outages: waiting for a database that cannot be reached for a while, then reporting it.

When PostgreSQL restarts, connections to it break. What was under way is done again once it answers,
which users notice as a pause. Any other error of a database is not an outage and is raised at once,
a full disk included.
"""

import time
from collections.abc import Callable
from typing import TypeVar

from sqlalchemy.exc import OperationalError, SQLAlchemyError

Result = TypeVar("Result")

PATIENCE_SECONDS = 10.0
PAUSE_SECONDS = 0.1

# SQLSTATE: connection exceptions; shut down by an operator, crashed, starting up. A connection
# that could not be made at all has none.
_UNREACHABLE = ("08", "57P01", "57P02", "57P03")


def is_outage(error: Exception) -> bool:
    """Whether the error only says that the database cannot be reached now."""
    if not isinstance(error, OperationalError):
        return False
    if error.connection_invalidated:
        return True
    state = getattr(error.orig, "sqlstate", "no such attribute: this is SQLite")
    return state is None or state.startswith(_UNREACHABLE)


def outlasting(action: Callable[[], Result], patience_seconds: float = PATIENCE_SECONDS) -> Result:
    """Call the work, repeatedly during an outage, and return its result, or raise."""
    deadline = time.monotonic() + patience_seconds
    while True:
        try:
            return action()
        except SQLAlchemyError as error:
            if not is_outage(error) or time.monotonic() > deadline:
                raise
        time.sleep(PAUSE_SECONDS)
