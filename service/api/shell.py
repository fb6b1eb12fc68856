"""The shell that all pages stand in: templates, and the static files that they name.

A static file's address holds the version of all of them, so browsers may keep it for good and a
new version is another address.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from http import HTTPStatus
from importlib.resources import files
from pathlib import Path
from typing import Any

from fastapi.templating import Jinja2Templates
from starlette.requests import HTTPConnection, Request
from starlette.responses import HTMLResponse

from service.api.place import ROOT
from service.api.static_files import StaticFolder

WEB = Path(str(files("web")))

templates = Jinja2Templates(WEB / "templates")


def page(request: Request, name: str, **values: str) -> HTMLResponse:
    """Return the page of a template, which starts the script of the same name."""
    return _rendered(request, name, {"modules": static().modules(f"pages/{name}.js"), **values})


def document(template: str, style_sheets: Sequence[str], **values: Any) -> str:
    """Return a page that stands alone: its style sheets are in it, and no script."""
    styles = "\n".join(
        (WEB / "static" / "styles" / sheet).read_text(encoding="utf-8") for sheet in style_sheets
    )
    return templates.get_template(f"{template}.html").render(styles=styles, **values)


def problem_page(
    status: int, title: str, detail: str, wanted: str, headers: Mapping[str, str] | None = None
) -> HTMLResponse:
    """Return a page that says what is wrong and what to do.

    Without a sign-in, that is to paste the token; the page then leads to the address that was
    `wanted`.
    """
    is_signed_out = status == HTTPStatus.UNAUTHORIZED
    values = {"title": title, "detail": detail, "wanted": wanted, "is_signed_out": is_signed_out}
    blank = Request({"type": "http", "headers": []})
    return _rendered(blank, "problem", {"modules": (), **values}, status, headers)


def wants_page(request: HTTPConnection) -> bool:
    """Whether a person's browser asked, to show the answer by itself."""
    return "text/html" in request.headers.get("accept", "")


def address_of(request: HTTPConnection) -> str:
    """Return the path and query of a request, to come back to."""
    path: str = request.scope["path"]
    query: bytes = request.scope.get("query_string", b"")
    return f"{path}?{query.decode('latin-1')}" if query else path


@cache
def static() -> StaticFolder:
    """Return the static files, read at the first call."""
    return StaticFolder(WEB / "static")


def _rendered(
    request: Request,
    name: str,
    values: Mapping[str, Any],
    status: int = HTTPStatus.OK,
    headers: Mapping[str, str] | None = None,
) -> HTMLResponse:
    root = ROOT.get()
    context = {
        "page": name,
        "root": root,
        "static": f"{root}/static/{static().version}",
        "caller": getattr(request.state, "caller", None),
        **values,
    }
    return templates.TemplateResponse(
        request, f"{name}.html", context, status_code=status, headers=headers
    )
