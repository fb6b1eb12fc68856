"""Figures of a sweep as files: all of its curves, or one of the paper's figures 2 to 6.

They are drawn in a process beside the service: a figure of many panels takes seconds.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from service.analysis.comparison import Comparison
from service.analysis.figures.figure_data import figure_data
from service.analysis.figures.figure_form import MEDIA_TYPES, Form
from service.analysis.figures.paper_figure import MAX_CURVES, PAPER, FigureNumber, PaperFigure
from service.api.access.authority import MAY_READ
from service.api.context import TheCheckpoints, TheCompared, TheSide, TheStore, TheSweep
from service.api.load.side_process import BusyError, Side, TooSlowError
from service.api.refusals.problems import (
    Fault,
    ImpossibleMove,
    InvalidRequest,
    NotFound,
    ServiceBusy,
)
from service.api.revalidation import REVALIDATED, RevalidatedRoute
from service.api.routes.results.curves import BandQuery, compared_by
from service.api.schemas.figure_query import FigureQuery
from service.model.compared import Compared
from service.model.sweep import Sweep
from service.store.store import Store
from workers.checkpoints.folder import UnavailableError
from workers.checkpoints.sealed_file import DamagedError

router = APIRouter(
    prefix="/sweeps/{sweep_id}",
    tags=["curves"],
    route_class=RevalidatedRoute,
    dependencies=[MAY_READ, *REVALIDATED],
)

CURVES = "service.analysis.figures.plot:draw"
DATA: dict[int | str, dict[str, Any]] = {
    200: {
        "content": {
            "text/csv": {
                "example": "metric,environment,entry,name,x,mean,low,high,n\r\n"
                "return_mean,Pendulum,ddpg,ddpg,800.0,0.012,-0.021,0.045,4\r\n"
            }
        }
    }
}
ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {"content": {each: {} for each in MEDIA_TYPES.values()}}
}


@router.get("/plot.csv", response_class=Response, responses=DATA)
def get_plot_data(
    sweep: TheCompared, query: Annotated[FigureQuery, Query()], store: TheStore
) -> Response:
    """Answer the numbers that `plot.{form}` draws for the same query."""
    data = figure_data(_asked_rows(store, sweep, query), query.design)
    headers = {"Content-Disposition": f'attachment; filename="sweep-{sweep.id}.csv"'}
    return Response(data, media_type="text/csv", headers=headers)


@router.get("/plot.{form}", response_class=Response, responses=ANSWERS)
def get_plot(
    sweep: TheCompared,
    form: Form,
    query: Annotated[FigureQuery, Query()],
    store: TheStore,
    side: TheSide,
) -> Response:
    """Draw curves of this sweep: a row of panels a metric, a column a task.

    Without any option: every curve, return_mean above return_history.
    """
    rows = _asked_rows(store, sweep, query)
    refuse_more_curves([query.design.chosen(row) for row in rows], MAX_CURVES)
    title = f"{sweep.name} ({sweep.id})"
    picture = drawn(side, CURVES, title, rows, form, query.design)
    return Response(picture, media_type=MEDIA_TYPES[form])


def _asked_rows(store: Store, sweep: Compared, query: FigureQuery) -> list[Comparison]:
    """Return a comparison a metric. Raises InvalidRequest for what the sweep does not have."""
    bands = BandQuery(
        normalized=query.normalized,
        band=query.band_asked,
        x=query.x,
        max_points=query.max_points,
    )
    views = [replace(bands.view(metric), with_seeds=query.seeds) for metric in query.metric]
    rows = compared_by(store, sweep, views)
    if faults := list(query.faults(rows[0])):
        raise InvalidRequest(faults)
    return rows


@router.get("/figures/{number}.csv", response_class=Response, responses=DATA)
def get_figure_data(
    sweep: TheSweep,
    number: FigureNumber,
    store: TheStore,
    checkpoints: TheCheckpoints,
    side: TheSide,
) -> Response:
    """Answer the numbers that `figures/{number}.{form}` draws.

    2 has the critics' values over states and actions, 3 the way of the die, the others their
    curves.
    """
    figure, rows = _paper_rows(store, sweep, number)
    policies = [checkpoints] if figure.shows_policies else []
    data: str = _worked_out(side, f"{figure.module}:numbers", rows, *policies)
    headers = {"Content-Disposition": f'attachment; filename="{sweep.id}-figure-{number}.csv"'}
    return Response(data, media_type="text/csv", headers=headers)


@router.get("/figures/{number}.{form}", response_class=Response, responses=ANSWERS)
def get_figure(
    sweep: TheSweep,
    number: FigureNumber,
    form: Form,
    store: TheStore,
    checkpoints: TheCheckpoints,
    side: TheSide,
) -> Response:
    """Draw one of the paper's figures from the runs of this sweep.

    2 shows the critics of `hybrid-ddpg` and `ddpg` on MassPoint as they learn, 3 the best runs of
    both and of `hybrid-ddpg-robust` on RollingDie. 4 shows those, `mpc` and `gd` as far as `ddpg`
    goes, 5 the cosine loss beside `ddpg`, 6 SAC and its hybrid: return_mean above return_history, a
    column a task, mean and standard deviation.
    """
    figure, rows = _paper_rows(store, sweep, number)
    title = f"Figure {number}, {figure.title}: {sweep.name} ({sweep.id})"
    policies = [checkpoints] if figure.shows_policies else []
    picture = drawn(side, f"{figure.module}:draw", title, rows, form, *policies)
    return Response(picture, media_type=MEDIA_TYPES[form])


def _paper_rows(
    store: Store, sweep: Sweep, number: FigureNumber
) -> tuple[PaperFigure, list[Comparison]]:
    """Return a figure and its comparisons. Raises NotFound, InvalidRequest for too many curves."""
    figure = PAPER[number]
    views = [BandQuery(normalized=figure.normalized).view(metric) for metric in figure.metrics]
    views = [
        replace(view, algorithms=figure.algorithms, environment=figure.environment)
        for view in views
    ]
    rows = compared_by(store, Compared([sweep]), views)
    if not rows[0].panels:
        where = f" on {figure.environment}" if figure.environment else ""
        raise NotFound(
            f"Figure {number} shows {', '.join(figure.algorithms)}{where}; sweep {sweep.id} has no "
            "run of them."
        )
    refuse_more_curves(rows, figure.max_curves)
    return figure, rows


def refuse_more_curves(rows: Sequence[Comparison], most: int) -> None:
    """Raise InvalidRequest for more curves than a reader can tell apart."""
    curves = sum(len(panel.curves) for panel in rows[0].panels)
    if curves > most:
        raise InvalidRequest(
            [Fault("sweep", f"has {curves} curves; this figure shows at most {most}", most)]
        )


def drawn(
    side: Side, draw: str, title: str, rows: Sequence[Comparison], form: Form, *more: object
) -> bytes:
    """Return a picture. Raises ImpossibleMove for damaged files, ServiceBusy."""
    picture: bytes = _worked_out(side, draw, title, rows, form, *more)
    return picture


def _worked_out(side: Side, function: str, *arguments: object) -> Any:
    try:
        return side.call(function, *arguments)
    except UnavailableError as trouble:
        raise ServiceBusy(f"What runs learned cannot be read now: {trouble.strerror}.") from trouble
    except DamagedError as damage:
        raise ImpossibleMove(f"What a run has learned cannot be read: {damage}.") from damage
    except (BusyError, TooSlowError, EOFError) as error:
        raise ServiceBusy(f"The figure could not be drawn: {error}.") from error
