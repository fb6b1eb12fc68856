"""The name of the latest commit, in the database itself.

A connection that is lost during a commit does not say whether the commit happened. The name does:
it is written in the same transaction, and there is one writer.
"""

from sqlalchemy import Connection, insert, select, update

from service.store.tables import last_commit


def note(connection: Connection, name: str) -> None:
    """Name the transaction that is under way."""
    if connection.execute(update(last_commit).values(name=name)).rowcount == 0:  # the first one
        connection.execute(insert(last_commit).values(name=name))


def name(connection: Connection) -> str | None:
    """Return the name of the latest commit."""
    return connection.scalar(select(last_commit.c.name))
