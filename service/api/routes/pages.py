"""The dashboard's pages and its static files. The pages hold no data: their scripts ask the API.

A page names every module that its script imports, directly or not, so that the browser asks for
them all at once and not one import after the other.
"""

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.types import Scope

from service.api.access.authority import MAY_READ, MAY_SEE_SHARED
from service.api.access.links import link_to
from service.api.place import here
from service.api.shell import page, static
from service.api.static_files import StaticFolder

FOR_GOOD = "public, max-age=31536000, immutable"

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


class VersionedFiles(StaticFiles):
    """Static files under `/{version}/`."""

    def __init__(self, static: StaticFolder) -> None:
        """Serve a folder."""
        super().__init__(directory=static.folder)
        self.version = static.version

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Answer a file; for good under the present version, else to be checked each time."""
        response = await super().get_response(path, scope)
        is_present = scope["path_params"]["version"] == self.version
        response.headers["Cache-Control"] = FOR_GOOD if is_present else "no-cache"
        return response


def add_pages(app: FastAPI) -> None:
    """Serve the pages, and under `/static` what they are made of."""
    app.include_router(router)
    app.mount("/static/{version}", VersionedFiles(static()), name="static")


@router.get("/", dependencies=[MAY_READ])
def sweeps_page(request: Request) -> HTMLResponse:
    """Answer the list of sweeps."""
    return page(request, "sweeps", service_url=link_to(request, ""))


@router.get("/favicon.ico", dependencies=[MAY_SEE_SHARED])
def favicon() -> RedirectResponse:
    """Answer browsers that ask by themselves, as on the API's own pages."""
    return RedirectResponse(here(f"/static/{static().version}/favicon.svg"))


@router.get("/sweeps/{sweep_id}", dependencies=[MAY_READ])
def sweep_page(request: Request, sweep_id: str) -> HTMLResponse:
    """Answer a sweep's page; its script reports a missing sweep."""
    return page(request, "sweep", sweep_id=sweep_id)


@router.get("/sweeps/{sweep_id}/runs", dependencies=[MAY_READ])
def runs_page(request: Request, sweep_id: str) -> HTMLResponse:
    """Answer the runs of a sweep."""
    return page(request, "runs", sweep_id=sweep_id)


@router.get("/runs/{run_id}", dependencies=[MAY_READ])
def run_page(request: Request, run_id: str) -> HTMLResponse:
    """Answer a run's page."""
    return page(request, "run", run_id=run_id)


@router.get("/workers", dependencies=[MAY_READ])
def workers_page(request: Request) -> HTMLResponse:
    """Answer the page of workers and the queue."""
    return page(request, "workers")


@router.get("/compare", dependencies=[MAY_SEE_SHARED])
def compare_page(request: Request) -> HTMLResponse:
    """Answer the comparison of the sweeps or runs that the address names."""
    return page(request, "compare")


@router.get("/catalogue", dependencies=[MAY_READ])
def catalogue_page(request: Request) -> HTMLResponse:
    """Answer the page of the catalogue."""
    return page(request, "catalogue")
