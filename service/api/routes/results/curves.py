"""Curves of a sweep: what its figures are drawn from too."""

from dataclasses import replace
from typing import Annotated

from fastapi import APIRouter, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from service.analysis.comparison import (
    MAX_TOTAL_POINTS,
    METRIC_TEXT,
    Abscissa,
    Comparison,
    View,
    compare,
)
from service.analysis.curves import Band
from service.api.access.authority import MAY_READ
from service.api.context import TheStore, TheSweep
from service.api.refusals.nearest import unknown_name
from service.api.refusals.problems import Fault, InvalidRequest
from service.api.revalidation import RevalidatedRoute
from service.api.schemas.curves_answer import CurvesAnswer, curves_json
from service.api.schemas.requests.sweep_request import MAX_RUNS
from service.api.schemas.requests.texts import Text
from service.model.environment import best_return
from service.model.request.entry import Entries
from service.model.run_curve import RETURNS
from service.model.sweep import Sweep
from service.store.store import Store

router = APIRouter(
    prefix="/sweeps/{sweep_id}",
    tags=["curves"],
    route_class=RevalidatedRoute,
    dependencies=[MAY_READ],
)

DEFAULT_POINTS = 300
MAX_POINTS = 10_000


class BandQuery(BaseModel):
    """How curves are drawn, whatever their metric."""

    model_config = ConfigDict(extra="forbid")

    normalized: bool | None = Field(
        default=None, description="0 acts at random, 1 is the best. Left out: true for returns."
    )
    band: Band = "std"
    x: Abscissa = Field(
        default="timesteps",
        description="`seconds`: processor time of training, without compiling and evaluation.",
    )
    max_points: int = Field(
        default=DEFAULT_POINTS,
        ge=2,
        le=MAX_POINTS,
        description=(
            "Of a curve, by leaving points out; fewer where all curves together would have more "
            f"than {MAX_TOTAL_POINTS}."
        ),
    )

    def view(self, metric: str) -> View:
        """Return the view of a metric."""
        is_normalized = metric in RETURNS if self.normalized is None else self.normalized
        return View(metric, is_normalized, self.band, self.x, self.max_points)


class CurveQuery(BandQuery):
    """Which curves, and how."""

    metric: Text = Field(
        default="return_mean",
        max_length=100,
        description="`return_mean`, `return_history`, or a diagnostic that the runs measure.",
    )
    seeds: bool = Field(default=False, description="Each run's own curve too.")
    run: int | None = Field(
        default=None,
        ge=0,
        le=MAX_RUNS,
        description="Of this run alone: the number at the end of its id.",
    )


@router.get("/curves", response_model=CurvesAnswer)
def get_curves(sweep: TheSweep, query: Annotated[CurveQuery, Query()], store: TheStore) -> Response:
    """Answer mean and band over seeds, exact, from all of them, with n."""
    view = replace(query.view(query.metric), with_seeds=query.seeds)
    comparison = compared(store, sweep, view, query.run)
    return Response(curves_json(sweep.id, comparison, query.seeds), media_type="application/json")


@router.get(
    "/metrics",
    responses={
        200: {
            "content": {
                "application/json": {"example": ["return_mean", "return_history", "critic_loss"]}
            }
        }
    },
)
def get_metrics(sweep: TheSweep, store: TheStore) -> list[str]:
    """List what curves can show: the returns, and the diagnostics that runs have measured."""
    return [*METRIC_TEXT, *store.diagnostic_names(sweep.id)]


def compared(store: Store, sweep: Sweep, view: View, run: int | None = None) -> Comparison:
    """Return the comparison of a sweep's runs, or of the one of that number.

    Raises InvalidRequest for a metric that cannot be shown.
    """
    _refuse_metric(store, sweep, view)
    runs = store.curve_points(sweep.id, view.metric, view.x, run)
    return compare(runs, Entries(sweep.request), view, store.random_returns(), best_return)


def _refuse_metric(store: Store, sweep: Sweep, view: View) -> None:
    if view.metric in RETURNS:
        return
    if view.metric not in (known := store.diagnostic_names(sweep.id)):
        raise InvalidRequest([unknown_name("metric", view.metric, [*sorted(RETURNS), *known])])
    if view.normalized:
        message = f"only returns have a normalised scale, {view.metric!r} has none"
        raise InvalidRequest([Fault("normalized", message)])
