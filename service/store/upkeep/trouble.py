"""What a database's errors mean to the operator: what is wrong and what to do.

These pass when their cause is gone; any other error is a fault of ours.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy.exc import DBAPIError

from service.store.upkeep.outage import is_outage

AFTERWARDS = (
    "The service then goes on by itself; nothing that was acknowledged is lost. "
    "Try again in a few seconds."
)


@dataclass(frozen=True)
class Trouble:
    """One kind of trouble: its name, what is wrong, what to do; the latter two are sentences."""

    name: str
    fact: str
    advice: str

    def __str__(self) -> str:
        """Say both."""
        return f"{self.fact} {self.advice}"


UNREACHABLE = Trouble(
    "database-unreachable",
    "The database cannot be reached.",
    "Start it, or repair the connection to it.",
)
FULL = Trouble(
    "database-full",
    "The disk of the database is full.",
    "Free some space there.",
)
FAILING = Trouble(
    "database-disk-failing",
    "The disk of the database fails (disk I/O error).",
    "See the machine's system log: the disk may be failing, or a file size limit was reached.",
)
READ_ONLY = Trouble(
    "database-read-only",
    "The database can be read but not written.",
    "Make its file, its folder and the file system writable again.",
)

# What PostgreSQL says, by SQLSTATE, and what SQLite says, by its words.
SQLSTATES: Mapping[str, Trouble] = {"53100": FULL, "58030": FAILING, "25006": READ_ONLY}
WORDS: Mapping[str, Trouble] = {
    "disk is full": FULL,
    "disk I/O error": FAILING,
    "readonly database": READ_ONLY,
    "unable to open database file": UNREACHABLE,
}


def find_trouble(error: Exception) -> Trouble | None:
    """Return the trouble behind an error; None if it is another fault."""
    if not isinstance(error, DBAPIError):
        return None
    if is_outage(error):
        return UNREACHABLE
    if state := getattr(error.orig, "sqlstate", None):
        return SQLSTATES.get(state)
    return next((WORDS[words] for words in WORDS if words in str(error.orig)), None)


def explain(error: Exception) -> str:
    """Say what is wrong and what to do, or else the text of the error, in one line."""
    if trouble := find_trouble(error):
        return str(trouble)
    said = str(getattr(error, "orig", error)).strip()
    return said.splitlines()[0] if said else type(error).__name__
