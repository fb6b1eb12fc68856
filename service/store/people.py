"""Users, shares and sessions: who may call the service. There are few, and they are read whole."""

from typing import Any

from sqlalchemy import Connection, delete, insert, or_, select, update

from service.model.caller import Scope, Session, Share, User
from service.store.column_types import now
from service.store.reading.rows import noun_of
from service.store.refusal import ImpossibleMoveError
from service.store.tables import sessions, shares, users


def all_users(connection: Connection) -> list[User]:
    """Return every user by name, revoked ones included."""
    rows = connection.execute(select(users).order_by(users.c.name))
    return [noun_of(User, row, scope=Scope(row.scope)) for row in rows]


def all_shares(connection: Connection) -> list[Share]:
    """Return the shares, the newest first."""
    rows = connection.execute(select(shares).order_by(shares.c.created_at.desc(), shares.c.id))
    return [noun_of(Share, row, sweeps=tuple(row.sweeps)) for row in rows]


def all_sessions(connection: Connection) -> list[Session]:
    """Return the sessions, the newest first."""
    rows = connection.execute(select(sessions).order_by(sessions.c.created_at.desc()))
    return [noun_of(Session, row) for row in rows]


def add_user(connection: Connection, name: str, scope: Scope, token_hash: str) -> None:
    """Make a user, or give one that was revoked another token. Raises ImpossibleMoveError."""
    values: dict[str, Any] = {"scope": scope.value, "token_hash": token_hash, "revoked_at": None}
    found = connection.execute(select(users).where(users.c.name == name)).one_or_none()
    if found is None:
        connection.execute(insert(users).values(name=name, **values))
    elif found.revoked_at is None:
        raise ImpossibleMoveError(
            f"there is a user {name!r} already: revoke it first to make a new token"
        )
    else:
        again = update(users).where(users.c.name == name).values(created_at=now(), **values)
        connection.execute(again)


def revoke_user(connection: Connection, name: str) -> None:
    """Revoke a user's token, and the sessions and shares that were made with it."""
    is_meant = (users.c.name == name) & users.c.revoked_at.is_(None)
    connection.execute(update(users).where(is_meant).values(revoked_at=now()))
    given = select(shares.c.token_hash).where(shares.c.made_by == name)
    connection.execute(
        delete(sessions).where(or_(sessions.c.name == name, sessions.c.key_hash.in_(given)))
    )
    connection.execute(delete(shares).where(shares.c.made_by == name))


def add_share(connection: Connection, share: Share) -> None:
    """Keep a share."""
    connection.execute(insert(shares).values(**{**vars(share), "sweeps": list(share.sweeps)}))


def remove_share(connection: Connection, share_id: str) -> None:
    """Revoke a share, with the sessions that it opened."""
    given = select(shares.c.token_hash).where(shares.c.id == share_id)
    connection.execute(delete(sessions).where(sessions.c.key_hash.in_(given)))
    connection.execute(delete(shares).where(shares.c.id == share_id))


def add_session(connection: Connection, session: Session, most: int) -> None:
    """Keep a session; what has expired goes, and the oldest where there are more than `most`."""
    connection.execute(delete(sessions).where(sessions.c.expires_at <= session.created_at))
    connection.execute(delete(shares).where(shares.c.expires_at <= session.created_at))
    newest = select(sessions.c.id).order_by(sessions.c.created_at.desc()).limit(most - 1)
    connection.execute(delete(sessions).where(sessions.c.id.not_in(newest)))
    connection.execute(insert(sessions).values(**vars(session)))


def remove_session(connection: Connection, session_id: str) -> None:
    """End a session."""
    connection.execute(delete(sessions).where(sessions.c.id == session_id))
