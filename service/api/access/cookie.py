"""The cookie of a session: it tells the service which browser calls."""

import hashlib
import hmac
from dataclasses import dataclass

from starlette.responses import Response

from service.address import Public
from service.api.access.register import SESSION_SECONDS


@dataclass(frozen=True)
class SessionCookie:
    """The name of the cookie, and where browsers send it."""

    name: str
    path: str
    is_secure: bool

    def put(self, response: Response, secret: str) -> None:
        """Set the cookie in an answer, which signs the browser in."""
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
        """Delete the cookie in an answer."""
        response.delete_cookie(
            self.name, path=self.path, httponly=True, samesite="strict", secure=self.is_secure
        )


def session_cookie(token: str, public: Public) -> SessionCookie:
    """Return the cookie of the service with that token at that address.

    Cookies ignore ports, and two services on one machine must not sign each other's browsers out.
    So the name depends on the token, which differs between services.
    """
    name = hmac.digest(token.encode(), b"cookie name", hashlib.sha256).hex()[:8]
    return SessionCookie(f"d3pg-{name}", public.prefix or "/", public.is_secure)
