"""Curves of a sweep, or of several as one: what its figures are drawn from too."""

from collections.abc import Sequence
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
from service.api.context import TheCompared, TheStore
from service.api.refusals.nearest import unknown_name
from service.api.refusals.problems import Fault, ImpossibleMove, InvalidRequest
from service.api.revalidation import REVALIDATED, RevalidatedRoute
from service.api.schemas.curves_answer import CurvesAnswer, curves_json
from service.api.schemas.requests.sweep_request import MAX_RUNS
from service.api.schemas.requests.texts import Text
from service.model.compared import Compared
from service.model.environment import best_return
from service.model.run_curve import RETURNS, RunCurve
from service.store.store import Store

router = APIRouter(
    prefix="/sweeps/{sweep_id}",
    tags=["curves"],
    route_class=RevalidatedRoute,
    dependencies=[MAY_READ, *REVALIDATED],
)

DEFAULT_POINTS = 300
MAX_POINTS = 10_000


class BandQuery(BaseModel):
    """How curves are drawn, whatever their metric."""

    model_config = ConfigDict(extra="forbid")

    normalized: bool | None = Field(
        default=None, description="0 acts at random, 1 is the best. By default true for returns."
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
            "Points of a curve, at most; others are left out. Fewer if all curves together would "
            f"have more than {MAX_TOTAL_POINTS}."
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
    seeds: bool = Field(default=False, description="The curve of each run, too.")
    run: int | None = Field(
        default=None,
        ge=0,
        le=MAX_RUNS,
        description="This run alone: the number at the end of its id.",
    )


@router.get("/curves", response_model=CurvesAnswer)
def get_curves(
    sweep: TheCompared, query: Annotated[CurveQuery, Query()], store: TheStore
) -> Response:
    """Answer mean and band over all seeds, exact, with n."""
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
def get_metrics(sweep: TheCompared, store: TheStore) -> list[str]:
    """List what curves can show: the returns, and the diagnostics that runs have measured."""
    return [*METRIC_TEXT, *_diagnostics(store, sweep)]


def compared(store: Store, sweep: Compared, view: View, run: int | None = None) -> Comparison:
    """Return the comparison of the runs of sweeps, or of the one of that number of a sweep.

    Raises InvalidRequest for what cannot be shown, ImpossibleMove as `run_curves`.
    """
    [comparison] = compared_by(store, sweep, [view], run)
    return comparison


def compared_by(
    store: Store, sweep: Compared, views: Sequence[View], run: int | None = None
) -> list[Comparison]:
    """Return what `compared` says for each view; they have one abscissa, and are read together."""
    if run is not None and len(sweep.sweeps) > 1:
        raise InvalidRequest(
            [Fault("run", "is for one sweep, not for several: leave it out, or name one sweep")]
        )
    _refuse_metrics(store, sweep, views)
    curves = run_curves(store, sweep, [view.metric for view in views], views[0].x, run)
    zeros = store.random_returns()
    return [
        compare(of_view, sweep.entries, view, zeros, best_return)
        for view, of_view in zip(views, curves, strict=True)
    ]


def run_curves(
    store: Store,
    sweep: Compared,
    metrics: Sequence[str],
    x: str = "timesteps",
    run: int | None = None,
    *,
    only_ends: bool = False,
) -> list[list[RunCurve]]:
    """Return each metric of every run, or its end. ImpossibleMove if runs cannot be compared."""
    own = [store.curves(each.id, metrics, x, run, only_ends=only_ends) for each in sweep.sweeps]
    try:
        return [sweep.joined(of_metric) for of_metric in zip(*own, strict=True)]
    except ValueError as error:
        raise ImpossibleMove(f"{error}.") from error


def _diagnostics(store: Store, sweep: Compared) -> list[str]:
    """The diagnostics that runs have measured, each once."""
    names = (name for each in sweep.sweeps for name in store.diagnostic_names(each.id))
    return list(dict.fromkeys(names))


def _refuse_metrics(store: Store, sweep: Compared, views: Sequence[View]) -> None:
    own = [view for view in views if view.metric not in RETURNS]
    known = _diagnostics(store, sweep) if own else []
    for view in own:
        if view.metric not in known:
            raise InvalidRequest([unknown_name("metric", view.metric, [*sorted(RETURNS), *known])])
        if view.normalized:
            message = f"only returns have a normalised scale, {view.metric!r} has none"
            raise InvalidRequest([Fault("normalized", message)])
