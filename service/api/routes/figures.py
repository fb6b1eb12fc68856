"""Figures of a sweep as files: all of its curves, or one of the paper's figures 2 to 6.

They are drawn in a process beside the service: a figure of many panels takes seconds.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from service.analysis.comparison import Comparison
from service.analysis.figures.figure_form import MEDIA_TYPES, Form
from service.analysis.figures.paper_figure import MAX_CURVES, PAPER, FigureNumber
from service.api.context import TheCheckpoints, TheSide, TheStore, TheSweep
from service.api.problems import Fault, ImpossibleMove, InvalidRequest, NotFound, ServiceBusy
from service.api.revalidation import RevalidatedRoute
from service.api.routes.curves import BandQuery, compared
from service.api.side_process import BusyError, Side, TooSlowError
from service.model.run_curve import RETURNS
from workers.checkpoints.folder import UnavailableError
from workers.checkpoints.place import Place
from workers.checkpoints.sealed_file import DamagedError

router = APIRouter(prefix="/sweeps/{sweep_id}", tags=["curves"], route_class=RevalidatedRoute)

ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {"content": {each: {} for each in MEDIA_TYPES.values()}}
}


@router.get("/plot.{form}", response_class=Response, responses=ANSWERS)
def get_plot(
    sweep: TheSweep,
    form: Form,
    query: Annotated[BandQuery, Query()],
    store: TheStore,
    side: TheSide,
) -> Response:
    """Draw every curve of this sweep: return_mean above return_history, a column a task."""
    rows = [compared(store, sweep, query.view(metric)) for metric in RETURNS]
    _refuse_more_curves(rows, MAX_CURVES)
    title = f"{sweep.name} ({sweep.id})"
    return _drawn(side, "service.analysis.figures.plot:draw", title, rows, form)


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
    figure = PAPER[number]
    views = [BandQuery(normalized=figure.normalized).view(metric) for metric in figure.metrics]
    rows = [
        compared(
            store,
            sweep,
            replace(view, algorithms=figure.algorithms, environment=figure.environment),
        )
        for view in views
    ]
    if not rows[0].panels:
        where = f" on {figure.environment}" if figure.environment else ""
        raise NotFound(
            f"Figure {number} shows {', '.join(figure.algorithms)}{where}; sweep {sweep.id} has no "
            "run of them."
        )
    _refuse_more_curves(rows, figure.max_curves)
    title = f"Figure {number}, {figure.title}: {sweep.name} ({sweep.id})"
    policies = [checkpoints] if figure.shows_policies else []
    return _drawn(side, figure.draw, title, rows, form, *policies)


def _refuse_more_curves(rows: Sequence[Comparison], most: int) -> None:
    """Raise InvalidRequest for more curves than eyes can tell apart."""
    curves = sum(len(panel.curves) for panel in rows[0].panels)
    if curves > most:
        raise InvalidRequest(
            [Fault("sweep", f"has {curves} curves; this figure shows at most {most}", most)]
        )


def _drawn(
    side: Side, draw: str, title: str, rows: Sequence[Comparison], form: Form, *policies: Place
) -> Response:
    """Draw. Raises ImpossibleMove for damaged files, ServiceBusy."""
    try:
        picture = side.call(draw, title, rows, form, *policies)
    except UnavailableError as trouble:
        raise ServiceBusy(f"What runs learned cannot be read now: {trouble.strerror}.") from trouble
    except DamagedError as damage:
        raise ImpossibleMove(f"What a run has learned cannot be read: {damage}.") from damage
    except (BusyError, TooSlowError, EOFError) as error:
        raise ServiceBusy(f"The figure could not be drawn: {error}.") from error
    return Response(picture, media_type=MEDIA_TYPES[form])
