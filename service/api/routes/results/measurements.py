"""What a run measured: every point, exact."""

from collections.abc import Iterator
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import StreamingResponse

from service.api.access.authority import MAY_READ
from service.api.context import TheRun, TheStore, TheSweep
from service.api.negotiation import asked_form
from service.api.schemas.measurements_answer import (
    MeasurementsAnswer,
    measurements_csv,
    measurements_json,
    sweep_heading,
    sweep_lines,
    table,
)
from service.model.request.entry import Entries
from service.model.run_name import RunName
from service.model.sweep import Sweep
from service.store.store import Store

router = APIRouter(tags=["runs"], dependencies=[MAY_READ])

Format = Literal["json", "csv"]
CSV_EXAMPLE = (
    "timestep,return_mean,return_history,updates,jacobians,seconds,compile_seconds,critic_loss\r\n"
    "800,-1203.5,-1203.5,400,25600,0.31,1.25,0.5\r\n"
)
SWEEP_EXAMPLE = (
    "run,label,algorithm,environment,w1,w2,config,seed,timestep,return_mean,return_history,updates,"
    "jacobians,seconds,compile_seconds,critic_loss\r\n"
    "3f9a0c51b7de-0,ddpg,ddpg,Pendulum,0.0,0.0,{},0,800,-1203.5,-1203.5,400,0,0.31,1.25,0.5\r\n"
)
RUNS_AT_ONCE = 256
MEDIA_TYPES: dict[Format, str] = {"json": "application/json", "csv": "text/csv"}


@router.get(
    "/runs/{run_id}/measurements",
    response_model=MeasurementsAnswer,
    responses={200: {"content": {"text/csv": {"example": CSV_EXAMPLE}}}},
)
def get_measurements(
    run: TheRun,
    request: Request,
    store: TheStore,
    format: Annotated[  # noqa: A002 - the name in the URL
        Format | None, Query(description="Left out: as the Accept header says, else JSON.")
    ] = None,
) -> Response:
    """Answer every measurement of a run, as JSON columns or as CSV."""
    columns = table(store.measurements(run.id))
    if asked_form(request, format, MEDIA_TYPES) == "json":
        return Response(measurements_json(run.id, columns), media_type="application/json")
    disposition = f'attachment; filename="{run.id}.csv"'
    return Response(
        measurements_csv(columns),
        media_type="text/csv",
        headers={"Content-Disposition": disposition},
    )


@router.get(
    "/sweeps/{sweep_id}/measurements",
    response_class=StreamingResponse,
    responses={
        200: {"content": {"text/csv": {"schema": {"type": "string"}, "example": SWEEP_EXAMPLE}}}
    },
)
def get_sweep_measurements(sweep: TheSweep, store: TheStore) -> StreamingResponse:
    """Answer every measurement of all runs of a sweep as CSV, a line a measurement."""
    disposition = f'attachment; filename="{sweep.id}.csv"'
    return StreamingResponse(
        _csv(sweep, store), media_type="text/csv", headers={"Content-Disposition": disposition}
    )


def _csv(sweep: Sweep, store: Store) -> Iterator[str]:
    """Yield the lines, some runs at a time."""
    label, diagnostics = Entries(sweep.request).label, store.diagnostic_names(sweep.id)
    yield sweep_heading(diagnostics)
    last = -1
    while found := store.sweep_measurements(sweep.id, last, RUNS_AT_ONCE):
        yield "".join(sweep_lines(run, label(run), points, diagnostics) for run, points in found)
        last = RunName.parse(found[-1][0].id).ordinal
