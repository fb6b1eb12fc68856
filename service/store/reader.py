"""Reading: each unit of work sees one state of the database, from whatever thread."""

from collections.abc import Callable
from typing import TypeVar

from sqlalchemy import Connection, Engine

from service.store.upkeep.outage import outlasting

Result = TypeVar("Result")


class Reader:
    """Runs units of work on connections that cannot write."""

    def __init__(self, engine: Engine) -> None:
        """Read over the engine's connections."""
        self._engine = engine

    def read(self, unit: Callable[[Connection], Result]) -> Result:
        """Run the unit and return what it returned; again where the connection was lost."""
        return outlasting(lambda: self._once(unit))

    def close(self) -> None:
        """Close the connections."""
        self._engine.dispose()

    def _once(self, unit: Callable[[Connection], Result]) -> Result:
        with self._engine.connect() as connection:
            return unit(connection)
