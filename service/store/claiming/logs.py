"""What workers print while they train: the end of it is kept with every attempt of the cohort."""

from collections.abc import Collection, Sequence
from typing import Any

from sqlalchemy import Connection, Row, tuple_, update

from service.model.run_name import RunName
from service.store.reading import events
from service.store.tables import attempts


def note(connection: Connection, printed: Sequence[tuple[Collection[Row[Any]], str]]) -> None:
    """Keep the last lines of each worker with the attempts of the runs that it holds, and tell."""
    for rows, text in printed:
        of_cohort = tuple_(attempts.c.run_number, attempts.c.attempt).in_(
            [(row.number, row.attempt) for row in rows]
        )
        connection.execute(update(attempts).where(of_cohort).values(log_tail=legible(text)))
    events.append(connection, [_told(rows) for rows, _ in printed])


def _told(rows: Collection[Row[Any]]) -> events.Change:
    first = next(iter(rows))
    names = [RunName(row.sweep_id, row.ordinal) for row in rows]
    return events.printed(first.sweep_number, first.sweep_id, names)


def legible(text: str) -> str:
    """Write as escapes what a program may print and no database holds: NUL, half surrogates."""
    return text.replace("\0", r"\x00").encode(errors="backslashreplace").decode()
