"""What workers print while they train: the end of it is kept with every attempt of the cohort."""

from collections.abc import Collection, Sequence
from typing import Any

from sqlalchemy import Connection, Row, select, update

from service.model.run_name import RunName
from service.store.reading import events
from service.store.tables import attempts, runs


def note(connection: Connection, printed: Sequence[tuple[Collection[Row[Any]], str]]) -> None:
    """Write the last lines of each worker to the attempts of its runs, with the events."""
    of_now = select(runs.c.attempt).where(runs.c.number == attempts.c.run_number)
    for rows, text in printed:
        of_cohort = attempts.c.run_number.in_([row.number for row in rows])
        of_attempts = of_cohort & (attempts.c.attempt == of_now.scalar_subquery())
        connection.execute(update(attempts).where(of_attempts).values(log_tail=legible(text)))
    events.append(connection, [_told(rows) for rows, _ in printed])


def _told(rows: Collection[Row[Any]]) -> events.Change:
    first = next(iter(rows))
    names = [RunName(row.sweep_id, row.ordinal) for row in rows]
    return events.printed(first.sweep_number, first.sweep_id, names)


def legible(text: str) -> str:
    """Escape what a program may print and no database holds: NUL, half surrogates."""
    return text.replace("\0", r"\x00").encode(errors="backslashreplace").decode()
