"""What the runs of a sweep have reached: the paper's table 1, in several forms."""

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.environment import best_return
from service.routes.context import TheStore, TheSweep
from service.routes.negotiation import asked_form
from service.schemas.score_table_answer import ScoreTableAnswer, score_table_csv
from service.score_table import ScoreTable, score_table
from service.score_table_text import latex, markdown
from service.scores import latest_scores
from service.sweep import Sweep

router = APIRouter(prefix="/sweeps/{sweep_id}", tags=["curves"])

TableForm = Literal["json", "csv", "markdown", "latex"]
MEDIA_TYPES: dict[TableForm, str] = {
    "json": "application/json",
    "csv": "text/csv",
    "markdown": "text/markdown",
    "latex": "application/x-latex",
}


class TableQuery(BaseModel):
    """Which returns, and in which form."""

    model_config = ConfigDict(extra="forbid")

    metric: Literal["return_history", "return_mean"] = "return_history"
    normalized: bool = Field(default=True, description="0 acts at random, 1 is the best.")
    format: TableForm | None = Field(
        default=None, description="Left out: as the Accept header says, else JSON."
    )


@router.get(
    "/table",
    response_model=ScoreTableAnswer,
    responses={200: {"content": {each: {} for each in MEDIA_TYPES.values()}}},
)
def get_table(
    sweep: TheSweep, query: Annotated[TableQuery, Query()], request: Request, store: TheStore
) -> Response:
    """Answer the paper's table 1 for this sweep: what every algorithm reached in every task."""
    runs = store.curve_points(sweep.id, query.metric)
    scores = latest_scores(runs, store.random_returns(), best_return, normalized=query.normalized)
    table = score_table(scores, query.metric, normalized=query.normalized)
    form = asked_form(request, query.format, MEDIA_TYPES)
    headers = {"Vary": "Accept"}
    if form == "csv":
        headers["Content-Disposition"] = f'attachment; filename="{sweep.id}-table.csv"'
    return Response(_written(form, sweep, table), media_type=MEDIA_TYPES[form], headers=headers)


def _written(form: TableForm, sweep: Sweep, table: ScoreTable) -> str:
    title = f"{sweep.name} ({sweep.id})"
    match form:
        case "json":
            return ScoreTableAnswer.of(sweep.id, table).model_dump_json()
        case "csv":
            return score_table_csv(table)
        case "markdown":
            return markdown(title, table)
        case "latex":
            return latex(title, table)
