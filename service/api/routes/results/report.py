"""A report of a sweep, or of several as one: an HTML file that is read without the service."""

import base64
import re
from collections.abc import Mapping
from datetime import UTC, datetime
from html import escape
from importlib.metadata import version
from typing import Any

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from service.analysis.comparison import Comparison, definition
from service.analysis.figures.design import Design
from service.analysis.figures.figure_data import figure_data
from service.analysis.figures.paper_figure import MAX_CURVES
from service.analysis.statistics.score_table import score_table
from service.api.access.authority import MAY_READ
from service.api.context import TheCompared, TheSide, TheStore
from service.api.load.side_process import Side
from service.api.refusals.problems import InvalidRequest
from service.api.report.parts import (
    Table,
    day,
    scores_table,
    settings_table,
    statistics_tables,
    sweep_part,
)
from service.api.revalidation import REVALIDATED, RevalidatedRoute
from service.api.routes.results.curves import BandQuery, compared
from service.api.routes.results.figures import CURVES, drawn, refuse_more_curves
from service.api.routes.results.scores import scores_of, statistics_of
from service.api.shell import document
from service.model.compared import Compared
from service.store.store import Store

router = APIRouter(
    prefix="/sweeps/{sweep_id}",
    tags=["curves"],
    route_class=RevalidatedRoute,
    dependencies=[MAY_READ, *REVALIDATED],
)

POINTS = 100  # of a curve: a report of 200 curves stays below 5 MB
DESIGN = Design(has_title=False, has_caption=False, font_size=9.0)
OWN_POLICY = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'"

EXAMPLE: dict[int | str, dict[str, Any]] = {
    200: {"content": {"text/html": {"example": "<!doctype html><title>first look</title> ..."}}}
}
OF_A_FILE = re.compile(r"^.*?(?=<svg)|<metadata>.*?</metadata>", re.DOTALL)
"""What an SVG does not need inside of HTML."""


@router.get("/report", response_class=HTMLResponse, responses=EXAMPLE)
def get_report(sweep: TheCompared, store: TheStore, side: TheSide) -> HTMLResponse:
    """Answer curves, scores, statistics, settings and how to repeat them, as one HTML file.

    It loads nothing and runs no script.
    """
    comparison = compared(store, sweep, BandQuery(max_points=POINTS).view("return_mean"))
    scores = scores_of(store, sweep, "final", normalized=True)
    statistics, without = _statistics(store, sweep)
    picture, caption = _figure(side, sweep, comparison)
    page = document(
        "report",
        ("tokens.css", "report.css"),
        name=sweep.name,
        version=version("d3pg"),
        made_at=day(datetime.now(UTC)),
        sweeps=[sweep_part(each, _fingerprint(store, each.id)) for each in sweep.sweeps],
        figure=picture,
        figure_data=base64.b64encode(figure_data([comparison], DESIGN).encode()).decode(),
        caption=caption,
        scores=scores_table(score_table(scores, "final", normalized=True)),
        statistics=statistics,
        without_statistics=without,
        settings=settings_table(sweep),
    )
    headers = {
        "Content-Disposition": f'inline; filename="{sweep.id}.html"',
        "Content-Security-Policy": OWN_POLICY,
    }
    return HTMLResponse(page, headers=headers)


def _figure(side: Side, sweep: Compared, comparison: Comparison) -> tuple[str, str]:
    """The curves as an element, and what they show; without one, why."""
    try:
        refuse_more_curves([comparison], MAX_CURVES)
    except InvalidRequest as refusal:
        return "", f"There is no figure: the sweep {refusal.faults[0].message}."
    picture = drawn(side, CURVES, sweep.name, [comparison], "svg", DESIGN)
    return inline_svg(picture, f"Learning curves of {sweep.name}"), definition([comparison])


def _statistics(store: Store, sweep: Compared) -> tuple[list[Table], str]:
    """The tables of the statistics that have rows; without any, why."""
    try:
        answer = statistics_of(store, sweep, "final")
    except InvalidRequest as refusal:
        return [], f"There are no statistics: {refusal.faults[0].message}."
    tables = [table for table in statistics_tables(answer) if table.rows]
    return tables, "No task has a score of every entry yet."


def _fingerprint(store: Store, sweep_id: str) -> Mapping[str, Any] | None:
    """The fingerprint of the sweep's first run."""
    first = store.list_runs(sweep_id, limit=1)
    return first[0].fingerprint if first else None


def inline_svg(picture: bytes, label: str) -> str:
    """Return an SVG as an element of a page, read out as `label`."""
    drawn = OF_A_FILE.sub("", picture.decode())
    return drawn.replace("<svg", f'<svg role="img" aria-label="{escape(label)}"', 1)
