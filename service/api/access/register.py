"""The register of who may call: the administrator, users, shares and sessions.

Tokens are random, of 256 bits, and only their SHA-256 is kept. A slow hash is for passwords, which
people choose and others guess; these cannot be guessed, so a fast hash is as safe, and every
request computes one. A token is looked up by its hash. The time that this takes tells something of
the hash of what was sent, which its sender knows, and nothing of any token.

Every request asks, so the register is held in memory, also while the database does not answer. It
is changed through its methods alone, which write the database first: no other process changes these
tables while a service works on them.
"""

import hashlib
import secrets
import threading
import time
from collections.abc import Callable, Mapping
from typing import ParamSpec

from service.model.caller import ADMINISTRATOR, Caller, Scope, Session, Share, User
from service.store.refusal import ImpossibleMoveError
from service.store.store import Store

P = ParamSpec("P")

TOKEN_BYTES = 32
DAY_SECONDS = 24 * 3600
SESSION_SECONDS = 30 * DAY_SECONDS
CODE_SECONDS = 600
MOST_SESSIONS = 10_000
MOST_CODES = 1000
MOST_SHARES = 1000
MAX_BROWSER = 200


class Register:
    """The callers that are known. Safe from any thread."""

    def __init__(
        self, store: Store, service_token: str, clock: Callable[[], float] = time.time
    ) -> None:
        """Read users, shares and sessions; the clock is for tests."""
        self._store = store
        self._clock = clock
        self._service_key = digest(service_token)
        self._lock = threading.RLock()
        self._codes: dict[str, tuple[str, float]] = {}  # the hash of each: whose, until when
        self._read()

    def by_token(self, token: str) -> Caller | None:
        """Return the caller with that token; None if nobody has it."""
        return self._holder(digest(token))

    def by_cookie(self, secret: str) -> Caller | None:
        """Return the caller whom a session's cookie signs in; None if there is no such session."""
        session = self._sessions.get(digest(secret))
        if session is None or session.expires_at <= self._clock():
            return None
        return self._holder(session.key_hash, session.id)

    def holds(self, caller: Caller) -> bool:
        """Whether a caller of some time ago would still be let in, as the same."""
        if caller.session is not None:
            expires_at = self._expiries.get(caller.session, 0.0)
            if expires_at <= self._clock():
                return False
        return self._holder(caller.key_hash, caller.session) == caller

    # ---- signing in

    def new_code(self, caller: Caller | None = None) -> str:
        """Return a code that signs a browser in as that caller, once, in the next ten minutes.

        Without a caller, as the administrator.
        """
        code, now = secrets.token_urlsafe(TOKEN_BYTES), self._clock()
        key = self._service_key if caller is None else caller.key_hash
        with self._lock:
            valid = [(name, each) for name, each in self._codes.items() if each[1] > now]
            newest = valid[-MOST_CODES + 1 :]
            self._codes = dict([*newest, (digest(code), (key, now + CODE_SECONDS))])
        return code

    def redeem(self, code: str) -> Caller | None:
        """Return the caller whom a code signs in, once; None if it is used, expired or unknown."""
        with self._lock:
            key, until = self._codes.pop(digest(code), ("", 0.0))
        return self._holder(key) if until > self._clock() else None

    def open_session(self, caller: Caller, browser: str) -> str:
        """Sign a browser in; return what its cookie is to hold."""
        secret, now = secrets.token_urlsafe(TOKEN_BYTES), self._clock()
        session = Session(
            id=secrets.token_hex(6),
            token_hash=digest(secret),
            key_hash=caller.key_hash,
            name=caller.name,
            browser=browser[:MAX_BROWSER],
            created_at=now,
            expires_at=now + SESSION_SECONDS,
        )
        self._change(self._store.add_session, session, MOST_SESSIONS)
        return secret

    def sessions(self) -> list[Session]:
        """Return the sessions that are open, the newest first."""
        return [
            each
            for each in self._sessions.values()
            if each.expires_at > self._clock() and self._holder(each.key_hash) is not None
        ]

    def end_session(self, session_id: str) -> None:
        """Sign a browser out."""
        self._change(self._store.remove_session, session_id)

    # ---- users

    def users(self) -> list[User]:
        """Return every user, those that were revoked too, by name."""
        return self._store.users()

    def add_user(self, name: str, scope: Scope) -> str:
        """Make a user and return its token, which cannot be found out again.

        Raises ImpossibleMoveError.
        """
        token = secrets.token_urlsafe(TOKEN_BYTES)
        self._change(self._store.add_user, name, scope, digest(token))
        return token

    def revoke_user(self, name: str) -> None:
        """Revoke a user: token, sessions and shares."""
        self._change(self._store.revoke_user, name)

    # ---- shares

    def shares(self) -> list[Share]:
        """Return the shares that have not expired, the newest first."""
        return [each for each in self._shares.values() if each.expires_at > self._clock()]

    def add_share(
        self, sweeps: tuple[str, ...], page: str, days: int, made_by: str
    ) -> tuple[Share, str]:
        """Make a share by which its token reads sweeps for some days; return it and the token.

        Raises ImpossibleMoveError.
        """
        if len(self.shares()) >= MOST_SHARES:
            raise ImpossibleMoveError(
                f"there are {MOST_SHARES} shares already: revoke some of them first"
            )
        token, now = secrets.token_urlsafe(TOKEN_BYTES), self._clock()
        share = Share(
            id=secrets.token_hex(6),
            token_hash=digest(token),
            sweeps=sweeps,
            page=page,
            made_by=made_by,
            created_at=now,
            expires_at=now + days * DAY_SECONDS,
        )
        self._change(self._store.add_share, share)
        return share, token

    def remove_share(self, share_id: str) -> None:
        """Revoke a share, and end the sessions that it opened."""
        self._change(self._store.remove_share, share_id)

    def page_of(self, caller: Caller) -> str | None:
        """Return the page that a caller's share opens; None for a caller without a share."""
        share = self._shares.get(caller.key_hash)
        return None if share is None else share.page

    def _holder(self, key: str, session: str | None = None) -> Caller | None:
        """Return the caller whose token has that hash."""
        if secrets.compare_digest(key, self._service_key):
            return Caller(ADMINISTRATOR, Scope.ADMIN, key, session)
        if (user := self._users.get(key)) is not None:
            return Caller(user.name, user.scope, key, session)
        share = self._shares.get(key)
        if share is None or share.expires_at <= self._clock():
            return None
        return Caller(f"share {share.id}", Scope.READ, key, session, frozenset(share.sweeps))

    def _change(self, command: Callable[P, None], *args: P.args, **kwargs: P.kwargs) -> None:
        """Change the database, then what is in memory."""
        with self._lock:
            command(*args, **kwargs)
            self._read()

    def _read(self) -> None:
        """Read users, shares and sessions from the database."""
        users = [each for each in self._store.users() if each.revoked_at is None]
        self._users: Mapping[str, User] = {each.token_hash: each for each in users}
        self._shares: Mapping[str, Share] = {s.token_hash: s for s in self._store.shares()}
        self._sessions: Mapping[str, Session] = {s.token_hash: s for s in self._store.sessions()}
        self._expiries = {session.id: session.expires_at for session in self._sessions.values()}


def digest(secret: str) -> str:
    """Return the SHA-256 of a token, a cookie or a code, in hexadecimal digits."""
    return hashlib.sha256(secret.encode(errors="replace")).hexdigest()
