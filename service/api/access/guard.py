"""Who may ask: one default-deny check in front of everything the service answers.

Binding 127.0.0.1 protects from other machines, not from web pages open in this machine's browser.
So every HTTP request and WebSocket handshake, to any route, must pass three checks:

1. Host: is it addressed to a name of ours? (A rebound foreign name is not: DNS rebinding.)
2. Origin, Sec-Fetch-Site: does it come from a page of ours, or from no page? (Cross-site requests.)
3. Token: `Authorization: Bearer TOKEN`, or the cookie of a session.

Only `PUBLIC_PATHS` and what lies under `PUBLIC_PREFIX` are exempt from the third. A new route is
covered without its author knowing of this file. What a caller may do is for the routes to say
(`authority`); here it is found out who calls.
"""

from collections.abc import Mapping
from http import HTTPStatus
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.access.cookie import SessionCookie
from service.api.access.register import Register
from service.api.refusals.problems import problem_response
from service.api.shell import address_of, problem_page, wants_page
from service.model.caller import Caller
from service.settings import Settings

PUBLIC_PATHS = frozenset({"/healthz", "/signin"})
PUBLIC_PREFIX = "/static/"
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
YEAR_SECONDS = 365 * 24 * 3600
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

    def __init__(
        self, app: ASGIApp, settings: Settings, register: Register, cookie: SessionCookie
    ) -> None:
        """Guard `app`."""
        self.app = app
        self.allowed_hosts = settings.allowed_hosts
        self.register = register
        self.cookie = cookie
        self.public = settings.public
        self.security_headers = security_headers(settings)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer for the application."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        request.state.caller = self._caller(request)
        refusal = self._refusal(request)
        if refusal is None:
            await self.app(scope, receive, self._with_security_headers(send))
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": WEBSOCKET_POLICY_VIOLATION})
        else:
            await refusal(scope, receive, self._with_security_headers(send))

    def _refusal(self, request: HTTPConnection) -> Response | None:
        host = request.headers.get("host", "")
        if host_name(host) not in self.allowed_hosts:
            return refusal_response(
                request,
                HTTPStatus.FORBIDDEN,
                f"This service does not answer to the host {host[:200]!r}. If people reach "
                "it by that name, start it with D3PG_PUBLIC_URL (--public-url), or with "
                "D3PG_ALLOW_HOST (--allow-host) naming it.",
            )
        if not comes_from_us(request, self.public.origin):
            return refusal_response(
                request,
                HTTPStatus.FORBIDDEN,
                "A page of another site sent this request; the service answers its own pages only.",
            )
        if is_public(request.scope["path"]) or request.state.caller is not None:
            return None
        return refusal_response(
            request,
            HTTPStatus.UNAUTHORIZED,
            "Not signed in. In a browser, open the sign-in link that the service prints when it "
            "starts, or a new one of `d3pg signin`; elsewhere send 'Authorization: Bearer TOKEN'.",
        )

    def _with_security_headers(self, send: Send) -> Send:
        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in self.security_headers.items():
                    headers.setdefault(name, value)
            await send(message)

        return send_with_headers

    def _caller(self, request: HTTPConnection) -> Caller | None:
        """Return who calls; None if unknown. A token in the request counts, even a wrong one."""
        scheme, _, token = request.headers.get("authorization", "").partition(" ")
        if scheme.lower() == "bearer":
            return self.register.by_token(token.strip())
        return self.register.by_cookie(request.cookies.get(self.cookie.name, ""))


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


def comes_from_us(request: HTTPConnection, public_origin: str) -> bool:
    """Whether no page of another origin sent this. Ours is the public one, or the host asked.

    Browsers send Sec-Fetch-Site with every request and Origin with every one that could do harm;
    neither can be set by a page. Programs send none. Following a link to us is allowed; the
    session cookie, SameSite=Strict, does not come along then.
    """
    origin = request.headers.get("origin")
    is_ours = origin is None or origin.lower() == public_origin or _is_asked(request, origin)
    if not is_ours:
        return False
    is_link = (
        request.scope.get("method", "WEBSOCKET") in SAFE_METHODS
        and request.headers.get("sec-fetch-mode") == "navigate"
    )
    site = request.headers.get("sec-fetch-site", "none")
    return site in {"same-origin", "none"} or is_link


def _is_asked(request: HTTPConnection, origin: str) -> bool:
    """Whether the page came from the host and port that the request names."""
    return urlsplit(origin).netloc.lower() == request.headers["host"].lower()


def is_public(path: str) -> bool:
    """Whether a path is answered without a token."""
    return path in PUBLIC_PATHS or path.startswith(PUBLIC_PREFIX)


def refusal_response(
    request: HTTPConnection, status: HTTPStatus, detail: str, wanted: str | None = None
) -> Response:
    """Return a refusal as a page for people, as a problem for programs.

    After signing in on the page, the browser goes to `wanted`; None: to the request's address.
    """
    is_stranger = status is HTTPStatus.UNAUTHORIZED
    headers = {"WWW-Authenticate": "Bearer"} if is_stranger else {}
    if not wants_page(request):
        return problem_response(status, detail, headers)
    title = "Not signed in" if is_stranger else status.phrase
    return problem_page(status, title, detail, wanted or address_of(request), headers)


def security_headers(settings: Settings) -> Mapping[str, str]:
    """Return the headers of every answer. Only an address with TLS is told to keep to TLS."""
    if not settings.public_url or not settings.public.is_secure:
        return SECURITY_HEADERS
    return {**SECURITY_HEADERS, "Strict-Transport-Security": f"max-age={YEAR_SECONDS}"}
