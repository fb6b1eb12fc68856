"""Who may ask: one default-deny check in front of everything the service answers.

Binding 127.0.0.1 protects from other machines, not from web pages open in this machine's browser.
So every HTTP request and WebSocket handshake, whatever route it is for, passes three questions:

1. Host: is it addressed to a name of ours? (A rebound foreign name is not: DNS rebinding.)
2. Origin, Sec-Fetch-Site: does it come from a page of ours, or from no page? (Cross-site requests.)
3. Token: `Authorization: Bearer TOKEN`, or the cookie that the sign-in link sets.

Only `PUBLIC_PATHS` and what lies under `PUBLIC_PREFIX` are let off the third. A new route is
covered without its author knowing of this file.
"""

import hmac
from http import HTTPStatus
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.access_token import session_cookie
from service.api.refusals.problems import problem_response
from service.api.shell import address_of, problem_page, wants_page
from service.settings import Settings

PUBLIC_PATHS = frozenset({"/healthz", "/signin"})
PUBLIC_PREFIX = "/static/"
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
WEBSOCKET_POLICY_VIOLATION = 1008

CONTENT_SECURITY_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; "
    "base-uri 'none'; frame-ancestors 'none'; form-action 'self'"
)
SECURITY_HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "private, no-cache",
}


class Guard:
    """Lets through what is addressed to us, comes from us and carries the token."""

    def __init__(self, app: ASGIApp, settings: Settings, token: str) -> None:
        """Guard `app`."""
        self.app = app
        self.allowed_hosts = settings.allowed_hosts
        self.token = token
        self.cookie_name, self.cookie_value = session_cookie(token)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer for the application."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        refusal = self._refusal(HTTPConnection(scope))
        if refusal is None:
            await self.app(scope, receive, _with_security_headers(send))
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": WEBSOCKET_POLICY_VIOLATION})
        else:
            await refusal(scope, receive, _with_security_headers(send))

    def _refusal(self, request: HTTPConnection) -> Response | None:
        host = request.headers.get("host", "")
        if host_name(host) not in self.allowed_hosts:
            return refusal_response(
                request,
                HTTPStatus.FORBIDDEN,
                f"This service does not answer to the host {host[:200]!r}. If it is a name of this "
                "machine, start the service with D3PG_ALLOW_HOST (--allow-host) naming it.",
            )
        if not comes_from_us(request):
            return refusal_response(
                request,
                HTTPStatus.FORBIDDEN,
                "A page of another site asked for this; the service answers its own pages only.",
            )
        if is_public(request.scope["path"]) or self._is_signed_in(request):
            return None
        return refusal_response(
            request,
            HTTPStatus.UNAUTHORIZED,
            "Not signed in. In a browser, open the sign-in link that the service prints when it "
            "starts; elsewhere send 'Authorization: Bearer TOKEN'. `d3pg token` prints the token.",
        )

    def _is_signed_in(self, request: HTTPConnection) -> bool:
        scheme, _, credential = request.headers.get("authorization", "").partition(" ")
        if scheme.lower() == "bearer":
            return is_equal_secret(credential.strip(), self.token)
        return is_equal_secret(request.cookies.get(self.cookie_name, ""), self.cookie_value)


def host_name(host: str) -> str:
    """Return a Host header's name in lower case without its port; empty if it is malformed."""
    try:
        parts = urlsplit(f"//{host}")
        if parts.netloc != host or "@" in host or parts.port == 0:
            return ""
    except ValueError:
        return ""
    name = parts.hostname or ""
    return f"[{name}]" if ":" in name else name


def comes_from_us(request: HTTPConnection) -> bool:
    """Whether no page of another origin sent this.

    Browsers send Sec-Fetch-Site with every request and Origin with every one that could do harm;
    neither can be set by a page. Programs send none. Following a link to us is allowed; the
    session cookie, SameSite=Strict, does not come along then.
    """
    origin = request.headers.get("origin")
    if origin is not None and urlsplit(origin).netloc.lower() != request.headers["host"].lower():
        return False
    is_link = (
        request.scope.get("method", "WEBSOCKET") in SAFE_METHODS
        and request.headers.get("sec-fetch-mode") == "navigate"
    )
    site = request.headers.get("sec-fetch-site", "none")
    return site in {"same-origin", "none"} or is_link


def is_public(path: str) -> bool:
    """Whether a path is answered without a token."""
    return path in PUBLIC_PATHS or path.startswith(PUBLIC_PREFIX)


def is_equal_secret(given: str, secret: str) -> bool:
    """Compare in a time that does not tell how much of it was right."""
    return hmac.compare_digest(given.encode(errors="replace"), secret.encode())


def refusal_response(
    request: HTTPConnection, status: HTTPStatus, detail: str, wanted: str | None = None
) -> Response:
    """Return a refusal as a page for people, as a problem for programs.

    Who signs in on the page is led on to the address that was `wanted`: of the request, if None.
    """
    is_stranger = status is HTTPStatus.UNAUTHORIZED
    headers = {"WWW-Authenticate": "Bearer"} if is_stranger else {}
    if not wants_page(request):
        return problem_response(status, detail, headers)
    title = "Not signed in" if is_stranger else status.phrase
    return problem_page(status, title, detail, wanted or address_of(request), headers)


def _with_security_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers
