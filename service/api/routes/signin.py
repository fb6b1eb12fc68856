"""Signing a browser in: the link that the service prints, exchanged for a cookie."""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response

from service.api.access_token import session_cookie
from service.api.security import is_equal_secret, refusal_response

router = APIRouter(include_in_schema=False)

NONE = "Paste the token of the service to sign this browser in."
WRONG = (
    "This sign-in link or token is not (or no longer) valid. The service prints the right link "
    "when it starts; `d3pg token` prints its token."
)
YEAR_SECONDS = 365 * 24 * 3600


@router.get("/signin")
def sign_in(
    request: Request,
    token: Annotated[str, Query(max_length=1000)] = "",
    next: Annotated[str, Query(max_length=1000)] = "/",  # noqa: A002 - the name in the URL
) -> Response:
    """Set the session cookie and go on to a page of ours; the token leaves the address bar."""
    secret: str = request.app.state.token
    target = next if _is_path_of_ours(next) else "/"
    if not is_equal_secret(token, secret):
        return refusal_response(request, HTTPStatus.UNAUTHORIZED, WRONG if token else NONE, target)
    response = _forward(request, target)
    name, value = session_cookie(secret)
    response.set_cookie(
        name,
        value,
        max_age=YEAR_SECONDS,
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    response.headers["Cache-Control"] = "no-store"
    response.headers["Referrer-Policy"] = "no-referrer"
    return response


def _is_path_of_ours(target: str) -> bool:
    """Whether a browser takes it for a path here; what follows two slashes is a host."""
    return target.startswith("/") and target[1:2] not in {"/", "\\"} and target.isprintable()


def _forward(request: Request, target: str) -> Response:
    """Redirect; by a page where the link was followed on another site.

    A redirect still counts as that site's request, and a SameSite=Strict cookie would not be sent
    along; what a page of ours opens is ours.
    """
    if request.headers.get("sec-fetch-site", "none") in {"none", "same-origin"}:
        return RedirectResponse(target, HTTPStatus.SEE_OTHER)
    quoted = RedirectResponse(target).headers["location"].replace("&", "&amp;").replace('"', "%22")
    return HTMLResponse(
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>d3pg</title>'
        f'<meta http-equiv="refresh" content="0; url={quoted}">'
        f'<p><a href="{quoted}">Signed in: go on</a></p></html>'
    )
