"""Users, shares and signed-in browsers."""

from __future__ import annotations

from collections.abc import Sequence

from service.api.schemas.people import (
    DAYS,
    NewShareAnswer,
    NewUserAnswer,
    SessionAnswer,
    ShareAnswer,
    SignInAnswer,
    UserAnswer,
)
from service.client.connection import Connection
from service.model.caller import Scope


class People(Connection):
    """Calls that concern who may call."""

    def users(self) -> list[UserAnswer]:
        """Users by name, revoked ones included; for administrators."""
        return self._list(UserAnswer, "/users")

    def add_user(self, name: str, scope: Scope | str) -> NewUserAnswer:
        """Add a user; the answer shows the token this once. For administrators.

        Args:
            name: lower case letters, digits, and `._-` after the first.
            scope: "metrics", "read", "submit" or "admin".
        """
        asked = {"name": name, "scope": str(scope)}
        answer = self._call("POST", "/users", json=asked)
        return NewUserAnswer.model_validate_json(answer.content)

    def revoke_user(self, name: str) -> UserAnswer:
        """Revoke a user's token, with its sessions and shares; for administrators."""
        answer = self._call("DELETE", f"/users/{name}")
        return UserAnswer.model_validate_json(answer.content)

    def share(
        self, sweep_ids: Sequence[str], *, days: int = DAYS, page: str | None = None
    ) -> NewShareAnswer:
        """Make a link by which anybody can read some sweeps, for a time.

        Args:
            sweep_ids: the sweeps.
            days: days until it expires.
            page: the path that it opens, such as "/compare?sweep=ID&sweep=ID&band=ci95"; by default
                the page of the sweep, or the comparison of several.
        """
        asked = {"sweeps": list(sweep_ids), "days": days, "page": page}
        answer = self._call("POST", "/shares", json=asked)
        return NewShareAnswer.model_validate_json(answer.content)

    def shares(self) -> list[ShareAnswer]:
        """The caller's shares that have not expired; for an administrator, those of all users."""
        return self._list(ShareAnswer, "/shares")

    def revoke_share(self, share_id: str) -> ShareAnswer:
        """Revoke a share, at once."""
        answer = self._call("DELETE", f"/shares/{share_id}")
        return ShareAnswer.model_validate_json(answer.content)

    def sign_in_link(self, page: str = "/") -> SignInAnswer:
        """A link that signs a browser in, once, within ten minutes.

        Args:
            page: the path that it opens.
        """
        answer = self._call("POST", "/sign-in-links", json={"page": page})
        return SignInAnswer.model_validate_json(answer.content)

    def sessions(self) -> list[SessionAnswer]:
        """The caller's signed-in browsers; for an administrator, those of all users."""
        return self._list(SessionAnswer, "/sessions")

    def end_session(self, session_id: str) -> SessionAnswer:
        """Sign a browser out, at once."""
        answer = self._call("DELETE", f"/sessions/{session_id}")
        return SessionAnswer.model_validate_json(answer.content)
