"""Results of a sweep's runs: the table, the statistics, the verdict, the search."""

from collections.abc import Sequence
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.analysis.comparison import grouped
from service.analysis.question.verdict import verdict
from service.analysis.statistics.paired_difference import paired_differences
from service.analysis.statistics.score import SCORES, Score
from service.analysis.statistics.score_table import ScoreTable, score_table
from service.analysis.statistics.score_table_text import latex, markdown
from service.analysis.statistics.scores import CellScores, sweep_scores
from service.analysis.statistics.sweep_statistics import sweep_statistics
from service.api.access.authority import MAY_READ
from service.api.context import TheCompared, TheStore, TheSweep
from service.api.negotiation import asked_form
from service.api.refusals.nearest import unknown_name
from service.api.refusals.problems import Fault, InvalidRequest, NotFound
from service.api.revalidation import REVALIDATED, RevalidatedRoute
from service.api.routes.results.curves import run_curves
from service.api.schemas.measured.scores_answer import ScoresAnswer
from service.api.schemas.question.verdict_answer import VerdictAnswer
from service.api.schemas.requests.texts import Text
from service.api.schemas.score_table_answer import ScoreTableAnswer, score_table_csv
from service.api.schemas.search.search_answer import SearchAnswer
from service.api.schemas.statistics_answer import StatisticsAnswer
from service.model.compared import Compared
from service.model.environment import best_return
from service.model.inquiry.question import Question
from service.model.request.entry import Entries
from service.queue.question_rounds import pairs_of
from service.queue.search_rounds import ladders_of, searches_that_tried
from service.store.store import Store

router = APIRouter(
    prefix="/sweeps/{sweep_id}",
    tags=["curves"],
    route_class=RevalidatedRoute,
    dependencies=[MAY_READ, *REVALIDATED],
)

MAX_COMPARED = 4_000_000
TableForm = Literal["json", "csv", "markdown", "latex"]
MEDIA_TYPES: dict[TableForm, str] = {
    "json": "application/json",
    "csv": "text/csv",
    "markdown": "text/markdown",
    "latex": "application/x-latex",
}
EXAMPLES = {
    "text/csv": {
        "example": "environment,label,algorithm,w1,w2,config,timesteps,runs,n,unfinished,mean,std,"
        "low,high,is_best\r\n"
        "Pendulum,ddpg,ddpg,0.0,0.0,{},20000,16,16,,0.731,0.042,0.709,0.753,True\r\n"
    },
    "text/markdown": {
        "example": "|  | Pendulum |\n| --- | ---: |\n| ddpg | **0.731** ± 0.042 (16) |\n"
    },
    "application/x-latex": {"example": r"ddpg & $\mathbf{0.731}$ $\pm$ 0.042 (16) \\"},
}


class ScoreQuery(BaseModel):
    """Which score of the runs."""

    model_config = ConfigDict(extra="forbid")

    score: Score = Field(
        default="final",
        description="; ".join(f"`{name}`: {kind.text}" for name, kind in SCORES.items()) + ".",
    )


class StatisticsQuery(ScoreQuery):
    """Which score, and the reference of the differences."""

    reference: Text | None = Field(
        default=None,
        description="Label of the entry that paired differences refer to. By default, each entry "
        "is compared with those of the algorithm that its own extends.",
    )


class ScaleQuery(ScoreQuery):
    """Which score, on which scale."""

    normalized: bool = Field(default=True, description="0 acts at random, 1 is the best.")


class TableQuery(ScaleQuery):
    """Which score, and in which form."""

    format: TableForm | None = Field(
        default=None, description="By default as the Accept header says, else JSON."
    )


@router.get(
    "/table",
    response_model=ScoreTableAnswer,
    responses={200: {"content": EXAMPLES}},
)
def get_table(
    sweep: TheCompared, query: Annotated[TableQuery, Query()], request: Request, store: TheStore
) -> Response:
    """Answer the score of every entry of the sweep in every task.

    With `score=return_history` it is the paper's table 1 for this sweep.
    """
    scores = scores_of(store, sweep, query.score, normalized=query.normalized)
    table = score_table(scores, query.score, normalized=query.normalized)
    form = asked_form(request, query.format, MEDIA_TYPES)
    headers = {"Vary": "Accept"}
    if form == "csv":
        headers["Content-Disposition"] = f'attachment; filename="{sweep.id}-table.csv"'
    return Response(_written(form, sweep, table), media_type=MEDIA_TYPES[form], headers=headers)


@router.get("/scores")
def get_scores(
    sweep: TheCompared, query: Annotated[ScaleQuery, Query()], store: TheStore
) -> ScoresAnswer:
    """Answer the score of every run: what the table and the statistics are made of."""
    cells = scores_of(store, sweep, query.score, normalized=query.normalized)
    return ScoresAnswer.of(sweep.id, query.score, cells, normalized=query.normalized)


@router.get("/statistics")
def get_statistics(
    sweep: TheCompared, query: Annotated[StatisticsQuery, Query()], store: TheStore
) -> StatisticsAnswer:
    """Answer statistics of the entries over all tasks, with intervals."""
    return statistics_of(store, sweep, query.score, query.reference)


def statistics_of(
    store: Store, sweep: Compared, score: Score, reference: str | None = None
) -> StatisticsAnswer:
    """Return the statistics. Raises InvalidRequest for an unknown reference, and too many runs."""
    _refuse_unknown(reference, [entry.label for entry in sweep.entries.all])
    cells = scores_of(store, sweep, score, normalized=True)
    _refuse_too_many(cells)
    [curves] = run_curves(store, sweep, ["return_mean"])
    differences = paired_differences(
        curves,
        sweep.entries,
        store.random_returns(),
        best_return,
        reference,
    )
    return StatisticsAnswer.of(sweep.id, score, sweep_statistics(cells), differences)


@router.get("/verdict")
def get_verdict(sweep: TheSweep, store: TheStore) -> VerdictAnswer:
    """Answer what is decided of the sweep's question, why, and how many more seeds it may take."""
    question = Question.of(sweep.request)
    if question is None:
        raise NotFound(f"Sweep {sweep.id} asks no question: submit one with `question`.")
    found = verdict(pairs_of(store, sweep, question), question)
    chosen = searches_that_tried(store, sweep)
    return VerdictAnswer.of(sweep.id, found, chosen, is_settled=not sweep.is_asking)


@router.get("/search")
def get_search(sweep: TheSweep, store: TheStore) -> SearchAnswer:
    """Answer how far the entries of the sweep's search have climbed, and which is the best."""
    if sweep.search is None:
        raise NotFound(f"Sweep {sweep.id} searches nothing: submit one with `search`.")
    climbed = ladders_of(store, sweep, sweep.search)
    entries = Entries(sweep.request)
    return SearchAnswer.of(sweep.id, sweep.search, climbed, entries, is_settled=not sweep.is_asking)


def scores_of(store: Store, sweep: Compared, score: Score, *, normalized: bool) -> list[CellScores]:
    """Return the scores of all cells. Raises ImpossibleMove as `run_curves`."""
    kind = SCORES[score]
    [curves] = run_curves(store, sweep, [kind.metric], only_ends=kind.of_end)
    return sweep_scores(
        curves,
        sweep.entries,
        score,
        store.random_returns(),
        best_return,
        normalized=normalized,
    )


def _refuse_unknown(reference: str | None, labels: Sequence[str]) -> None:
    if reference is not None and reference not in labels:
        raise InvalidRequest([unknown_name("reference", reference, labels)])


def _refuse_too_many(cells: Sequence[CellScores]) -> None:
    """Raise InvalidRequest if comparing all curves would take minutes."""
    curves = len({cell.label for cell in cells})
    compared = curves**2 * sum(
        max(len(cell.seeds) for cell in own) ** 2
        for own in grouped(cells, lambda cell: cell.spec.environment).values()
    )
    if compared > MAX_COMPARED:
        message = (
            f"its {curves} curves have {compared} pairs of runs to compare in all tasks; "
            f"statistics are limited to {MAX_COMPARED}: submit what you want to compare on its own"
        )
        raise InvalidRequest([Fault("sweep", message, MAX_COMPARED)])


def _written(form: TableForm, sweep: Compared, table: ScoreTable) -> str:
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
