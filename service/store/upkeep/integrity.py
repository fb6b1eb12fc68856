"""Whether a database is intact: the database's own check, and conditions on its rows."""

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import Connection, text

# What must hold -> how many rows break it.
INVARIANTS: Mapping[str, str] = {
    "a running run holds a lease, no other does": """
        SELECT count(*) FROM runs WHERE (status = 'running') <> (lease_until IS NOT NULL)""",
    "a run waits, runs, or has ended and says when": """
        SELECT count(*) FROM runs WHERE NOT CASE
        WHEN status IN ('queued', 'paused', 'running') THEN finished_at IS NULL
        WHEN status IN ('succeeded', 'failed', 'diverged', 'cancelled') THEN finished_at IS NOT NULL
        ELSE false END""",
    "only a running run is being cancelled": """
        SELECT count(*) FROM runs WHERE is_cancelling AND status <> 'running'""",
    "a run has as many attempts as it was claimed": """
        SELECT count(*) FROM runs WHERE attempt <>
        (SELECT count(*) FROM attempts WHERE attempts.run_number = runs.number)""",
    "the current attempt of a running run is open, no other is": """
        SELECT count(*) FROM attempts JOIN runs ON runs.number = attempts.run_number
        WHERE (attempts.ended_at IS NULL) <>
        (runs.status = 'running' AND attempts.attempt = runs.attempt)""",
    "the runs of a sweep are numbered from 0 without a gap": """
        SELECT count(*) FROM (SELECT 1 FROM runs GROUP BY sweep_number
        HAVING min(ordinal) <> 0 OR max(ordinal) <> count(*) - 1) AS gaps""",
    "a sweep has runs": """
        SELECT count(*) FROM sweeps
        WHERE deleted_at IS NULL
        AND NOT EXISTS (SELECT 1 FROM runs WHERE runs.sweep_number = sweeps.number)""",
    "a measurement is a run's, and its diagnostics have names": """
        SELECT count(*) FROM measurements
        WHERE run_number NOT IN (SELECT number FROM runs)
        OR diagnostic_set NOT IN (SELECT number FROM diagnostic_sets)""",
    "a diagnosis waits, or has found something, or says why not": """
        SELECT count(*) FROM diagnoses
        WHERE NOT CASE WHEN is_waiting THEN findings IS NULL AND problem = ''
        ELSE (findings IS NULL) = (problem <> '') END""",
    "an event is a sweep's": """
        SELECT count(*) FROM events WHERE sweep_number NOT IN (SELECT number FROM sweeps)""",
    "a measurement's floats are whole, and there are those that all have": """
        SELECT count(*) FROM measurements WHERE length(packed) % 8 <> 0 OR length(packed) < 32""",
}


@dataclass(frozen=True)
class Check:
    """A condition, and what breaks it; `faults` is empty if it holds."""

    claim: str
    faults: tuple[str, ...]


def check(connection: Connection) -> list[Check]:
    """Check everything."""
    checks = _sqlite_checks(connection) if connection.dialect.name == "sqlite" else []
    for claim, query in INVARIANTS.items():
        rows = connection.scalar(text(query))
        checks.append(Check(claim, (f"{rows} rows break it",) if rows else ()))
    return checks


def _sqlite_checks(connection: Connection) -> list[Check]:
    pages = tuple(connection.scalars(text("PRAGMA integrity_check")))
    strays = connection.execute(text("PRAGMA foreign_key_check")).all()
    return [
        Check("SQLite finds its file intact", () if pages == ("ok",) else pages),
        Check(
            "every row refers to rows that exist",
            tuple(f"row {row[1]} of {row[0]} refers to no row of {row[2]}" for row in strays),
        ),
    ]
