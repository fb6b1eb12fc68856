"""Figures of a sweep as files: all of its curves, or one of the paper's figures.

They are drawn in a process beside the service: a figure of many panels takes seconds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Response

from service.comparison import Comparison
from service.figures.figure_form import MEDIA_TYPES, Form
from service.problems import Busy, Fault, InvalidRequest, NotFound
from service.routes.context import TheSide, TheStore, TheSweep
from service.routes.curves import BandQuery, compared
from service.routes.revalidation import RevalidatedRoute
from service.side_process import BusyError, Side, TooSlowError
from service.store.store import Store
from service.sweep import Sweep

router = APIRouter(prefix="/sweeps/{sweep_id}", tags=["curves"], route_class=RevalidatedRoute)

MAX_CURVES = 500
ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {"content": {each: {} for each in MEDIA_TYPES.values()}}
}
FigureNumber = Literal["4", "5", "6"]
ROWS = ("return_mean", "return_history")


@dataclass(frozen=True)
class CurveFigure:
    """One of the paper's figures of curves: what it is called, and whose curves it shows."""

    title: str
    algorithms: tuple[str, ...]


PAPER: Mapping[FigureNumber, CurveFigure] = {
    "4": CurveFigure("the hybrid and what it is measured by", ("hybrid-ddpg", "ddpg", "mpc", "gd")),
    "5": CurveFigure("the cosine loss", ("hybrid-ddpg-cosine", "ddpg")),
    "6": CurveFigure("soft actor-critic", ("hybrid-sac", "sac")),
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
    rows = [compared(store, sweep.id, query, metric) for metric in ROWS]
    return _drawn(side, sweep.name, sweep, rows, form)


@router.get("/figures/{number}.{form}", response_class=Response, responses=ANSWERS)
def get_figure(
    sweep: TheSweep, number: FigureNumber, form: Form, store: TheStore, side: TheSide
) -> Response:
    """Draw one of the paper's figures from the runs of this sweep.

    4 shows `hybrid-ddpg`, `ddpg`, `mpc` and `gd`, 5 the cosine loss beside `ddpg`, 6 SAC and its
    hybrid: return_mean above return_history, a column a task, mean and standard deviation.
    """
    figure = PAPER[number]
    rows = _rows(store, sweep, figure.algorithms)
    if not rows[0].panels:
        raise NotFound(
            f"Figure {number} shows {', '.join(figure.algorithms)}; sweep {sweep.id} has no run of "
            "them."
        )
    return _drawn(side, f"Figure {number}, {figure.title}: {sweep.name}", sweep, rows, form)


def _rows(store: Store, sweep: Sweep, algorithms: Sequence[str]) -> list[Comparison]:
    query = BandQuery()
    return [compared(store, sweep.id, query, metric, algorithms=algorithms) for metric in ROWS]


def _drawn(
    side: Side, title: str, sweep: Sweep, rows: Sequence[Comparison], form: Form
) -> Response:
    """Draw rows. Raises InvalidRequest for more curves than eyes can tell apart, Busy."""
    curves = sum(len(panel.curves) for panel in rows[0].panels)
    if curves > MAX_CURVES:
        message = f"has {curves} curves; a figure shows at most {MAX_CURVES}"
        raise InvalidRequest([Fault("sweep", message, MAX_CURVES)])
    try:
        picture = side.call("service.figures.plot:draw", f"{title} ({sweep.id})", rows, form)
    except (BusyError, TooSlowError, EOFError) as error:
        raise Busy(f"The figure could not be drawn: {error}.") from error
    return Response(picture, media_type=MEDIA_TYPES[form])
