"""Users, shares and sessions in the database, on each backend."""

import pytest

from service.model.caller import Scope, Session, Share
from service.store.refusal import ImpossibleMoveError
from service.store.store import Store

HOUR = 3600.0


def session(name: str, key: str, created_at: float, hours: float = 1.0) -> Session:
    secret = f"{name} {created_at}"
    return Session(
        id=secret,
        token_hash=f"hash of {secret}",
        key_hash=key,
        name=name,
        browser="a browser",
        created_at=created_at,
        expires_at=created_at + hours * HOUR,
    )


def share(name: str, made_by: str, created_at: float = 0.0) -> Share:
    return Share(name, f"key of {name}", ("a", "b"), "/sweeps/a", made_by, created_at, HOUR)


def test_a_name_stays_one_persons(store: Store) -> None:
    store.add_user("ann", Scope.SUBMIT, "first")
    with pytest.raises(ImpossibleMoveError, match="there is a user 'ann' already"):
        store.add_user("ann", Scope.ADMIN, "second")
    store.revoke_user("ann")
    assert [user.revoked_at is None for user in store.users()] == [False]
    store.add_user("ann", Scope.READ, "third")
    [again] = store.users()
    assert (again.scope, again.token_hash, again.revoked_at) == (Scope.READ, "third", None)


def test_whoever_is_revoked_takes_sessions_and_shares_along(store: Store) -> None:
    store.add_user("ann", Scope.SUBMIT, "ann's")
    store.add_share(share("hers", "ann"))
    store.add_share(share("another", "ben", 1.0))
    for place, (name, key) in enumerate(
        (("ann", "ann's"), ("share hers", "key of hers"), ("share another", "key of another"))
    ):
        store.add_session(session(name, key, float(place)), 10)
    store.revoke_user("ann")
    assert [each.name for each in store.sessions()] == ["share another"]
    assert [(each.id, each.sweeps) for each in store.shares()] == [("another", ("a", "b"))]
    store.remove_share("another")
    assert not store.sessions()
    assert not store.shares()


def test_sessions_are_bounded_and_end(store: Store) -> None:
    for second in range(4):
        store.add_session(session("ann", "key", float(second)), 3)
    assert [each.created_at for each in store.sessions()] == [3.0, 2.0, 1.0]
    store.remove_session("ann 2.0")
    store.add_share(share("old", "ann"))
    store.add_session(session("ann", "key", 1.0 + HOUR), 3)
    assert [each.created_at for each in store.sessions()] == [1.0 + HOUR, 3.0]
    assert not store.shares(), "what has expired went with the sessions that had"
