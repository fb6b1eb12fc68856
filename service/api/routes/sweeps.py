"""Sweeps: submitting one, listing them, looking at one."""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import JSONResponse
from pydantic import Field

from service.analysis.cost import cell_costs
from service.api.context import TheStore, TheSweep, TheWorkerMemory, TheWorkforce
from service.api.problems import Fault, InvalidRequest
from service.api.schemas.listed_sweep_answer import SPARKLINE_POINTS, ListedSweepAnswer
from service.api.schemas.page import Page, PageQuery, page_of, read_cursor
from service.api.schemas.sweep_answer import DryRunAnswer, SweepAnswer
from service.api.schemas.sweep_edit import OneTag, SweepEdit
from service.api.schemas.sweep_request import SweepRequest
from service.api.schemas.texts import MAX_NAME, Name, Text
from service.api.submission.plan import plan
from service.model.environment import best_return
from service.model.standing import best_of
from service.model.sweep import SweepStatus
from service.store.reading.sweep_search import Archived, SweepSearch
from service.store.refusal import SubmissionKeyReusedError

router = APIRouter(prefix="/sweeps", tags=["sweeps"])

SubmissionKey = Annotated[
    str | None,
    Header(
        min_length=1,
        max_length=255,
        pattern=r"^[\x20-\x7e]+$",
        description="A text of the client's own, new for every sweep: makes a retry safe.",
    ),
]


@router.post(
    "",
    status_code=HTTPStatus.ACCEPTED,
    response_model=SweepAnswer,
    responses={200: {"model": DryRunAnswer, "description": "With `dry_run=true`."}},
)
def submit_sweep(
    request: SweepRequest,
    response: Response,
    store: TheStore,
    workforce: TheWorkforce,
    worker_memory: TheWorkerMemory,
    dry_run: Annotated[
        bool, Query(description="Only say what would be queued, and about what it would cost.")
    ] = False,
    idempotency_key: SubmissionKey = None,
) -> SweepAnswer | JSONResponse:
    """Queue a sweep: all of its runs in one transaction, or none.

    Submitted again under the same `Idempotency-Key`, it is the same sweep, for as long as that is
    kept; the key with another request is refused.
    """
    planned = plan(request, worker_memory)
    if dry_run:
        past = store.past_costs(planned.algorithms, planned.environment_versions)
        costs = cell_costs(planned.cells, len(planned.seeds), past)
        answer = DryRunAnswer.of(planned, costs, len(workforce.workers))
        return JSONResponse(answer.model_dump(mode="json"))
    try:
        sweep = store.create_sweep(
            request.name,
            request.priority,
            request.model_dump(mode="json", exclude_unset=True),
            planned.specs(),
            entries=planned.places(),
            notes=request.notes,
            tags=request.tags,
            environment_versions=planned.environment_versions,
            submission_key=idempotency_key,
        )
    except SubmissionKeyReusedError as refusal:
        raise InvalidRequest([Fault("Idempotency-Key", str(refusal))]) from refusal
    response.headers["Location"] = f"/api/v1/sweeps/{sweep.id}"
    return SweepAnswer.of(sweep, planned.notices)


class SweepQuery(PageQuery):
    """Which sweeps."""

    q: Text | None = Field(
        default=None,
        max_length=MAX_NAME,
        description="A text in the name, the notes or a tag, or the beginning of the id.",
    )
    tag: OneTag | None = None
    algorithm: Name | None = None
    environment: Name | None = None
    status: SweepStatus | None = None
    archived: Archived = "false"

    @property
    def search(self) -> SweepSearch:
        """What is asked of the store."""
        return SweepSearch(
            self.q, self.tag, self.algorithm, self.environment, self.status, self.archived
        )


@router.get("")
def list_sweeps(
    query: Annotated[SweepQuery, Query()], request: Request, response: Response, store: TheStore
) -> Page[ListedSweepAnswer]:
    """List sweeps, newest first; those that are archived only where they are asked for."""
    sweeps = store.list_sweeps(read_cursor(query.after), query.limit + 1, query.search)
    cells = store.sweep_standings([sweep.id for sweep in sweeps[: query.limit]])
    best = best_of(cells, store.random_returns(), best_return)
    outlines = store.sweep_outlines([each.cell for each in best.values()], SPARKLINE_POINTS)
    answers = [
        ListedSweepAnswer.of(sweep, best.get(sweep.id), outlines.get(sweep.id, ()))
        for sweep in sweeps
    ]
    return page_of(answers, query.limit, request, response)


@router.patch("/{sweep_id}")
def edit_sweep(sweep: TheSweep, edit: SweepEdit, store: TheStore) -> SweepAnswer:
    """Change how a sweep is described, found and ranked; at any time."""
    return SweepAnswer.of(store.edit_sweep(sweep.id, edit.changes))


@router.get("/{sweep_id}")
def get_sweep(sweep: TheSweep) -> SweepAnswer:
    """Show a sweep: its status, counts of runs, progress."""
    return SweepAnswer.of(sweep)
