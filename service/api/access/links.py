"""Addresses of this service that people open."""

from urllib.parse import urlencode

from fastapi import Request

from service.settings import Settings


def link_to(request: Request, path: str) -> str:
    """Return the address of a path: below the public address, else below the request's."""
    settings: Settings = request.app.state.settings
    base = settings.public.url if settings.public_url else str(request.base_url).rstrip("/")
    return f"{base}{path}"


def signin_path(code: str, page: str = "/") -> str:
    """Return the path that signs a browser in by a code and opens a page."""
    wanted = {} if page == "/" else {"next": page}
    return f"/signin?{urlencode({'code': code} | wanted)}"
