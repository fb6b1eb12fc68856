"""The dashboard's pages and its static files. The pages hold no data: their scripts ask the API."""

from importlib.resources import files
from pathlib import Path

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import HTMLResponse
from fastapi.staticfiles import StaticFiles
from fastapi.templating import Jinja2Templates

WEB = Path(str(files("web")))

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
templates = Jinja2Templates(WEB / "templates")


def add_pages(app: FastAPI) -> None:
    """Serve the pages, and under `/static` what they are made of."""
    app.include_router(router)
    app.mount("/static", StaticFiles(directory=WEB / "static"), name="static")


@router.get("/")
def sweeps_page(request: Request) -> HTMLResponse:
    """Answer the list of sweeps."""
    return templates.TemplateResponse(request, "sweeps.html", {"page": "sweeps"})


@router.get("/sweeps/{sweep_id}")
def sweep_page(request: Request, sweep_id: str) -> HTMLResponse:
    """Answer a sweep's page; that there is no such sweep is for its script to find out."""
    return templates.TemplateResponse(request, "sweep.html", {"sweep_id": sweep_id})
