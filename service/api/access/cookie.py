"""The cookie of a session: it tells the service which browser calls."""

import hashlib
import hmac
from dataclasses import dataclass

from starlette.responses import Response

from service.address import Public
from service.api.access.register import SESSION_SECONDS


@dataclass(frozen=True)
class SessionCookie:
    """How the cookie is called, and where browsers send it."""

    name: str
    path: str
    is_secure: bool

    def put(self, response: Response, secret: str) -> None:
        """Sign the browser in that an answer goes to."""
        response.set_cookie(
            self.name,
            secret,
            max_age=SESSION_SECONDS,
            path=self.path,
            httponly=True,
            samesite="strict",
            secure=self.is_secure,
        )

    def take_away(self, response: Response) -> None:
        """Have the browser forget it."""
        response.delete_cookie(
            self.name, path=self.path, httponly=True, samesite="strict", secure=self.is_secure
        )


def session_cookie(token: str, public: Public) -> SessionCookie:
    """Return the cookie of the service that has a token and is found at a place.

    Cookies do not know ports, and two services on one machine, which have other tokens, must not
    sign each other's browsers out: so the name follows from the token.
    """
    name = hmac.digest(token.encode(), b"cookie name", hashlib.sha256).hex()[:8]
    return SessionCookie(f"d3pg-{name}", public.prefix or "/", public.is_secure)
