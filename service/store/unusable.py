"""Databases that cannot be opened: what is wrong, and what the operator can do.

When PostgreSQL refuses a connection, its error has no SQLSTATE, only words, which may be in another
language; then the advice is general.
"""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import URL
from sqlalchemy.exc import SQLAlchemyError

from service.store.refusal import UnfitServerError

OLDEST_SERVER = 14
ENCODING = "UTF8"
GENERAL = "Check that the server is up and that D3PG_DATABASE_URL is right."
MAKE = "createdb --owner={user} --encoding=UTF8 --template=template0 {database}"
LOGIN = (
    "Write the password of {user} into ~/.pgpass (HOST:PORT:DATABASE:USER:PASSWORD, chmod 600) or "
    "into D3PG_DATABASE_URL."
)
OWNER = (
    "Make {user} its owner, on the server: psql -c 'ALTER DATABASE {database} OWNER TO {user}'. "
    "Where another user made its tables: psql {database} -c 'REASSIGN OWNED BY OTHER TO {user}'."
)
ROOM = "The service keeps up to 17 connections: end others, or raise max_connections."
ADVICE: Mapping[str, str] = {
    "password authentication failed": LOGIN,
    "no password supplied": LOGIN,
    "no pg_hba.conf entry": "Let {user} in from this machine, in pg_hba.conf of the server.",
    'role "{user}" does not exist': "Make it on the server: createuser --pwprompt {user}",
    'database "{database}" does not exist': f"Make it on the server: {MAKE}",
    "permission denied": OWNER,
    "must be owner": OWNER,
    "read-only transaction": "It is a standby, or set to be read only: name the primary server.",
    "too many": ROOM,
    "connection slots are reserved": ROOM,
}
"""What to do, by the words of PostgreSQL."""


def unusable(url: URL, error: SQLAlchemyError) -> str:
    """Say which database cannot be opened, why, and what to do."""
    if url.get_backend_name() == "sqlite":
        return (
            f"{url.database} cannot be opened as a database: {reason_of(error)}. Put a backup "
            "there (`d3pg db backup` makes them), or move it away to begin with an empty one."
        )
    shown = url.render_as_string(hide_password=True)
    return f"{shown} cannot be opened: {reason_of(error)}. {advice(url, error) or GENERAL}"


def reason_of(error: SQLAlchemyError) -> str:
    """Return the message of the database, in one line."""
    return str(getattr(error, "orig", error)).strip().splitlines()[0]


def advice(url: URL, error: SQLAlchemyError) -> str | None:
    """Return what to do about a PostgreSQL that cannot be opened; None if that is not known."""
    named = {"user": url.username or "the user", "database": url.database or url.username}
    said = str(getattr(error, "orig", error))
    found = (text for words, text in ADVICE.items() if words.format(**named) in said)
    return next((text.format(**named) for text in found), None)


def refuse_unfit(connection: Any, *_: object) -> None:
    """Raise UnfitServerError for a PostgreSQL that is too old or has another encoding.

    `connection` is psycopg's, just made; the server has told both by then.
    """
    info = connection.info
    encoding = info.parameter_status("server_encoding")
    found: list[str] = []
    expected: list[str] = []
    if info.server_version < 10_000 * OLDEST_SERVER:
        found.append(f"PostgreSQL {info.server_version // 10_000}")
        expected.append(f"PostgreSQL {OLDEST_SERVER} or newer: install one, and move the database")
    if encoding != ENCODING:
        found.append(f"the encoding {encoding}")
        named = MAKE.format(user=info.user, database="NEW_NAME")
        expected.append(
            f"the encoding {ENCODING}: make a database with it ({named}), name it in "
            "D3PG_DATABASE_URL"
        )
    if found:
        text = (
            f"the database {info.dbname} has {' and '.join(found)}, where the service needs "
            f"{', and '.join(expected)}; move the data of the old one with pg_dump"
        )
        connection.close()
        raise UnfitServerError(text)
