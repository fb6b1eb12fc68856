"""Signing a browser in and out.

A browser follows a link with a code, which is valid once and for minutes, or a person pastes a
token, which is posted and so is in no address. Either is exchanged for the cookie of a session. A
shared link leads to this page, too: its token is behind the #, which browsers do not send, and the
page's script puts it into the form.
"""

from http import HTTPStatus
from typing import Annotated
from urllib.parse import parse_qs

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from starlette.concurrency import run_in_threadpool

from service.api.access.authority import MAY_SEE_SHARED, OPEN
from service.api.access.cookie import SessionCookie
from service.api.access.guard import refusal_response
from service.api.access.register import Register
from service.api.place import here
from service.model.caller import Caller, Scope

router = APIRouter(include_in_schema=False)

NONE = "Paste a token to sign this browser in: the service's, or your own."
USED = (
    "This sign-in link was used, or is not (or no longer) valid: a link signs in one browser, "
    "within ten minutes. `d3pg signin` prints a new one, or paste a token."
)
WRONG = (
    "This token is not valid, or not any more. `d3pg token` prints the token of the service; an "
    "administrator makes others with `d3pg users add`."
)
SCRAPES = "This token is for reading /metrics alone and cannot sign a browser in."


@router.get("/signin", dependencies=[OPEN])
def sign_in_by_code(
    request: Request,
    code: Annotated[str, Query(max_length=1000)] = "",
    next: Annotated[str, Query(max_length=1000)] = "/",  # noqa: A002 - the name in the URL
) -> Response:
    """Sign in by a code and redirect to a page of ours; a signed-in browser goes there at once."""
    register: Register = request.app.state.register
    target = next if is_path_of_ours(next) else "/"
    caller = register.redeem(code) if code else None
    if caller is not None:
        return _signed_in(request, caller, target)
    present: Caller | None = request.state.caller
    if code and present is not None and present.sweeps is None:
        return _forward(request, target)
    return refusal_response(request, HTTPStatus.UNAUTHORIZED, USED if code else NONE, target)


@router.post("/signin", dependencies=[OPEN])
async def sign_in_by_token(request: Request) -> Response:
    """Sign in by the token in a form, and redirect to a page of ours."""
    register: Register = request.app.state.register
    fields = parse_qs((await request.body()).decode(errors="replace"))
    wanted = fields.get("next", ["/"])[0]
    target = wanted if is_path_of_ours(wanted) else "/"
    caller = register.by_token(fields.get("token", [""])[0].strip())
    if caller is None or caller.scope is Scope.METRICS:
        text = WRONG if caller is None else SCRAPES
        return refusal_response(request, HTTPStatus.UNAUTHORIZED, text, target)
    present: Caller | None = request.state.caller
    target = register.page_of(caller) or target
    if present is not None and caller.sweeps and all(map(present.sees, caller.sweeps)):
        return _forward(request, target)  # a shared link does not sign anybody out
    return await run_in_threadpool(_signed_in, request, caller, target)


@router.post("/signout", dependencies=[MAY_SEE_SHARED])
def sign_out(request: Request) -> Response:
    """End the session that the browser has."""
    caller: Caller = request.state.caller
    if caller.session is not None:
        request.app.state.register.end_session(caller.session)
    response = RedirectResponse(here("/signin"), HTTPStatus.SEE_OTHER)
    cookie: SessionCookie = request.app.state.cookie
    cookie.take_away(response)
    return response


def is_path_of_ours(target: str) -> bool:
    """Whether browsers read it as a path of this service; after two slashes, they read a host."""
    return target.startswith("/") and target[1:2] not in {"/", "\\"} and target.isprintable()


def _signed_in(request: Request, caller: Caller, target: str) -> Response:
    """Open a session, and redirect."""
    register: Register = request.app.state.register
    secret = register.open_session(caller, request.headers.get("user-agent", ""))
    response = _forward(request, target)
    cookie: SessionCookie = request.app.state.cookie
    cookie.put(response, secret)
    response.headers["Cache-Control"] = "no-store"
    response.headers["Referrer-Policy"] = "no-referrer"
    return response


def _forward(request: Request, target: str) -> Response:
    """Redirect; by a page if the link was followed on another site.

    A redirect would still count as that site's request, without a SameSite=Strict cookie. What a
    page of ours opens has the cookie.
    """
    response = RedirectResponse(here(target), HTTPStatus.SEE_OTHER)
    if request.headers.get("sec-fetch-site", "none") in {"none", "same-origin"}:
        return response
    quoted = response.headers["location"].replace("&", "&amp;").replace('"', "%22")
    return HTMLResponse(
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>d3pg</title>'
        f'<meta http-equiv="refresh" content="0; url={quoted}">'
        f'<p><a href="{quoted}">Signed in: go on</a></p></html>'
    )
