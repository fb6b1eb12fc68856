"""Curves and figures of a sweep, both from one aggregate."""

from typing import Annotated

from fastapi import APIRouter, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from service.comparison import RETURNS, Abscissa, Comparison, View, compare
from service.curves import Band
from service.environment import environment_facts
from service.plot import Form, draw
from service.problems import Fault, InvalidRequest
from service.routes.context import TheStore, TheSweep
from service.schemas.curves_answer import CurvesAnswer, curves_json
from service.schemas.sweep_request import Text
from service.store.store import Store
from service.submission.nearest import unknown_name

router = APIRouter(prefix="/sweeps/{sweep_id}", tags=["curves"])

DEFAULT_POINTS = 300
MAX_POINTS = 10_000
MEDIA_TYPES: dict[Form, str] = {"png": "image/png", "svg": "image/svg+xml"}


class BandQuery(BaseModel):
    """How curves are drawn, whatever their metric."""

    model_config = ConfigDict(extra="forbid")

    normalized: bool | None = Field(
        default=None, description="0 acts at random, 1 is the best. Left out: true for returns."
    )
    band: Band = "std"
    x: Abscissa = "timesteps"
    max_points: int = Field(default=DEFAULT_POINTS, ge=2, le=MAX_POINTS)


class CurveQuery(BandQuery):
    """Which curves, and how."""

    metric: Text = Field(
        default="return_mean",
        max_length=100,
        description="`return_mean`, `return_history`, or a diagnostic that the runs measure.",
    )
    seeds: bool = Field(default=False, description="Each run's own curve too.")


@router.get("/curves", response_model=CurvesAnswer)
def get_curves(sweep: TheSweep, query: Annotated[CurveQuery, Query()], store: TheStore) -> Response:
    """Answer mean and band over seeds, exact, from all of them, with n."""
    comparison = compared(store, sweep.id, view(query, query.metric))
    return Response(curves_json(sweep.id, comparison, query.seeds), media_type="application/json")


@router.get("/plot.png", response_class=Response, responses={200: {"content": {"image/png": {}}}})
def get_png(sweep: TheSweep, query: Annotated[BandQuery, Query()], store: TheStore) -> Response:
    """Draw the paper's figure 4 for this sweep: return_mean above return_history."""
    return _figure(store, sweep.id, sweep.name, query, "png")


@router.get(
    "/plot.svg", response_class=Response, responses={200: {"content": {"image/svg+xml": {}}}}
)
def get_svg(sweep: TheSweep, query: Annotated[BandQuery, Query()], store: TheStore) -> Response:
    """Draw the same figure in vectors."""
    return _figure(store, sweep.id, sweep.name, query, "svg")


def view(query: BandQuery, metric: str) -> View:
    """Return the view that is asked for. Raises InvalidRequest for what cannot be normalised."""
    if query.normalized and metric not in RETURNS:
        fault = Fault("normalized", f"only returns have a normalised scale, {metric!r} has none")
        raise InvalidRequest([fault])
    normalized = metric in RETURNS if query.normalized is None else query.normalized
    return View(metric, normalized, query.band, query.x, query.max_points)


def compared(store: Store, sweep_id: str, asked: View) -> Comparison:
    """Return a sweep's comparison. Raises InvalidRequest for a metric that no run measures."""
    if asked.metric not in RETURNS:
        known = store.diagnostic_names(sweep_id)
        if asked.metric not in known:
            raise InvalidRequest([_unknown_metric(asked.metric, known)])
    return compare(
        store.curve_points(sweep_id, asked.metric, asked.x),
        asked,
        store.random_returns(),
        lambda environment: environment_facts(environment).best_return,
    )


def _unknown_metric(metric: str, diagnostics: list[str]) -> Fault:
    return unknown_name("metric", metric, [*sorted(RETURNS), *diagnostics])


def _figure(store: Store, sweep_id: str, name: str, query: BandQuery, form: Form) -> Response:
    rows = [
        compared(store, sweep_id, view(query, metric))
        for metric in ("return_mean", "return_history")
    ]
    return Response(draw(f"{name} ({sweep_id})", rows, form), media_type=MEDIA_TYPES[form])
