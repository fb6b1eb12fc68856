"""What a run measured: every point, exact."""

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response

from service.api.context import TheRun, TheStore
from service.api.negotiation import asked_form
from service.api.schemas.measurements_answer import (
    MeasurementsAnswer,
    measurements_csv,
    measurements_json,
    table,
)

router = APIRouter(tags=["runs"])

Format = Literal["json", "csv"]
CSV_EXAMPLE = (
    "timestep,return_mean,return_history,updates,jacobians,seconds,compile_seconds,critic_loss\r\n"
    "800,-1203.5,-1203.5,400,25600,0.31,1.25,0.5\r\n"
)
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
