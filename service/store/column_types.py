"""Column types that return exactly what was stored, and the database's own clock."""

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from sqlalchemy import Dialect, Double, Text, TypeDecorator
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement


class Exact(TypeDecorator[float]):
    """A float64. NULL is how NaN is written and NaN is how NULL is read; infinities stay.

    SQLite keeps every bit but the sign of a zero.

    SQLite turns NaN into NULL by itself and PostgreSQL does not; saying it here makes both alike.
    A column of this type therefore cannot also mean "no value".
    """

    impl = Double
    cache_ok = True

    def process_bind_param(self, value: float | None, dialect: Dialect) -> float | None:
        """NaN becomes NULL."""
        del dialect
        return None if value is None or math.isnan(value) else float(value)

    def process_result_value(self, value: float | None, dialect: Dialect) -> float:
        """NULL becomes NaN."""
        del dialect
        return math.nan if value is None else value

    def result_processor(self, dialect: Dialect, coltype: object) -> Callable[[Any], float]:
        """Skip the two calls a value that the general decorator makes."""
        del dialect, coltype
        return lambda value: math.nan if value is None else value


class Document(TypeDecorator[Mapping[str, Any]]):
    """A JSON object as ASCII text, its keys in the order they came."""

    impl = Text
    cache_ok = True

    def process_bind_param(self, value: Mapping[str, Any] | None, dialect: Dialect) -> str | None:
        """Write it. NaN and infinities are refused: JSON has none."""
        del dialect
        return None if value is None else json.dumps(value, allow_nan=False)

    def process_result_value(self, value: str | None, dialect: Dialect) -> Any:
        """Read it."""
        del dialect
        return None if value is None else json.loads(value)


class now(FunctionElement[float]):  # noqa: N801  (reads as the SQL function it is)
    """Seconds since 1970 by the database's clock: the one clock that leases are kept by.

    It stands still within a statement.
    """

    type = Double()
    inherit_cache = True


@compiles(now, "sqlite")
def _sqlite_now(element: now, compiler: SQLCompiler, **_: Any) -> str:
    del element, compiler
    return "unixepoch('now', 'subsec')"


@compiles(now, "postgresql")
def _postgresql_now(element: now, compiler: SQLCompiler, **_: Any) -> str:
    del element, compiler
    return "extract(epoch from statement_timestamp())::double precision"
