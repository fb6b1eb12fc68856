"""Who calls the service and what they may do: scopes, users, shares, sessions."""

from dataclasses import dataclass
from enum import StrEnum

from service.model.compared import SEPARATOR

ADMINISTRATOR = "admin"
"""The name of the holder of the service's own token; no user can have it."""


class Scope(StrEnum):
    """What a token allows. Each allows what those before it allow."""

    METRICS = "metrics"
    """Reading `/metrics`, for Prometheus, and nothing else."""
    READ = "read"
    """Reading everything."""
    SUBMIT = "submit"
    """Submitting sweeps; changing and deleting the caller's own sweeps."""
    ADMIN = "admin"
    """Changing and deleting every sweep; users."""

    def includes(self, needed: "Scope") -> bool:
        """Whether it allows what the other one does."""
        order = list(Scope)
        return order.index(self) >= order.index(needed)


@dataclass(frozen=True)
class User:
    """A person or a program with a token of its own. Times are seconds since 1970.

    token_hash  SHA-256 of the token, in hexadecimal digits; the token itself is kept nowhere
    revoked_at  since when the token is invalid; None: it is valid
    """

    name: str
    scope: Scope
    token_hash: str
    created_at: float
    revoked_at: float | None


@dataclass(frozen=True)
class Share:
    """A link by which anybody can read some sweeps, for a time.

    page     the address, from `/` on, that it opens
    made_by  the name of its author
    """

    id: str
    token_hash: str
    sweeps: tuple[str, ...]
    page: str
    made_by: str
    created_at: float
    expires_at: float


@dataclass(frozen=True)
class Session:
    """A browser that is signed in. It stands for a token, and is invalid without it.

    token_hash  of what the browser's cookie holds
    key_hash    of the user's, the share's or the service's token that it was signed in with
    name        of the user who signed in, for lists
    browser     its user agent
    """

    id: str
    token_hash: str
    key_hash: str
    name: str
    browser: str
    created_at: float
    expires_at: float


@dataclass(frozen=True)
class Caller:
    """The origin of a request.

    key_hash  of the token that it came with, or that its session stands for
    session   the id of the session that it came by; None: it came with a token
    sweeps    ids of the sweeps that it may see; None: all
    """

    name: str
    scope: Scope
    key_hash: str
    session: str | None = None
    sweeps: frozenset[str] | None = None

    def sees(self, sweep_id: str | None) -> bool:
        """Whether it may see a sweep, or all of several; for None, what belongs to no sweep."""
        if self.sweeps is None:
            return True
        return sweep_id is not None and self.sweeps.issuperset(sweep_id.split(SEPARATOR))

    def may_change(self, owner: str) -> bool:
        """Whether sweeps of that owner are its own to change."""
        return self.scope is Scope.ADMIN or owner == self.name
