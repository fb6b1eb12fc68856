"""The measurements of runs: every point, exact."""

from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import StreamingResponse

from algorithms.measurement import Measurement
from service.api.access.authority import MAY_READ
from service.api.context import TheRun, TheStore, TheSweep
from service.api.negotiation import asked_form
from service.api.refusals.problems import Fault, InvalidRequest
from service.api.schemas.measured.measurements_answer import (
    MeasurementsAnswer,
    measurements_csv,
    measurements_json,
    sweep_heading,
    sweep_lines,
    table,
)
from service.model.request.entry import Entries
from service.model.run import Run
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
SweepFormat = Literal["csv", "parquet"]
SWEEP_MEDIA_TYPES: dict[SweepFormat, str] = {
    "csv": "text/csv",
    "parquet": "application/vnd.apache.parquet",
}


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
        Format | None, Query(description="By default as the Accept header says, else JSON.")
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
        200: {
            "content": {
                "text/csv": {"schema": {"type": "string"}, "example": SWEEP_EXAMPLE},
                SWEEP_MEDIA_TYPES["parquet"]: {"schema": {"type": "string", "format": "binary"}},
            }
        }
    },
)
def get_sweep_measurements(
    sweep: TheSweep,
    request: Request,
    store: TheStore,
    format: Annotated[  # noqa: A002 - the name in the URL
        SweepFormat | None, Query(description="By default as the Accept header says, else CSV.")
    ] = None,
) -> StreamingResponse:
    """Answer every measurement of all runs of a sweep, a row a measurement.

    As Parquet, numbers keep their types, and repeated texts cost nothing; that needs the extra
    `parquet` where the service runs.
    """
    form = asked_form(request, format, SWEEP_MEDIA_TYPES)
    disposition = f'attachment; filename="{sweep.id}.{form}"'
    return StreamingResponse(
        _csv(sweep, store) if form == "csv" else _parquet(sweep, store),
        media_type=SWEEP_MEDIA_TYPES[form],
        headers={"Content-Disposition": disposition, "Vary": "Accept"},
    )


def _csv(sweep: Sweep, store: Store) -> Iterator[str]:
    """Yield the lines, some runs at a time."""
    label, diagnostics = Entries(sweep.request).label, store.diagnostic_names(sweep.id)
    yield sweep_heading(diagnostics)
    for found in _measured(sweep, store):
        yield "".join(sweep_lines(run, label(run), points, diagnostics) for run, points in found)


def _parquet(sweep: Sweep, store: Store) -> Iterator[bytes]:
    """Return the parts of the file. Raises InvalidRequest where Parquet cannot be written."""
    try:
        writer = import_module("service.api.schemas.measured.measurements_parquet")
    except ModuleNotFoundError as error:
        raise InvalidRequest([Fault("format", f"the service cannot write it: {error}")]) from error
    label, diagnostics = Entries(sweep.request).label, store.diagnostic_names(sweep.id)
    groups = (
        [(run, label(run), points) for run, points in found] for found in _measured(sweep, store)
    )
    parts: Iterator[bytes] = writer.parquet_parts(groups, diagnostics)
    return parts


def _measured(sweep: Sweep, store: Store) -> Iterator[Sequence[tuple[Run, list[Measurement]]]]:
    """Yield the runs with what they measured, some at a time: a large sweep is never held."""
    last = -1
    while found := store.sweep_measurements(sweep.id, last, RUNS_AT_ONCE):
        yield found
        last = RunName.parse(found[-1][0].id).ordinal
