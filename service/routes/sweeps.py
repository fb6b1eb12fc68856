"""Sweeps: submitting one, listing them, looking at one, cancelling it."""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import JSONResponse

from service.cost import cell_costs
from service.problems import ImpossibleMove
from service.routes.context import TheDispatcher, TheStore, TheSweep
from service.schemas.page import Page, PageQuery, page_of, read_cursor
from service.schemas.sweep_answer import DryRunAnswer, SweepAnswer
from service.schemas.sweep_request import SweepRequest
from service.store.refusal import ImpossibleMoveError
from service.submission.plan import plan

router = APIRouter(prefix="/sweeps", tags=["sweeps"])


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
    dispatcher: TheDispatcher,
    dry_run: Annotated[
        bool, Query(description="Only say what would be queued, and about what it would cost.")
    ] = False,
) -> SweepAnswer | JSONResponse:
    """Queue a sweep: all of its runs in one transaction, or none."""
    planned = plan(request)
    if dry_run:
        past = store.past_costs(planned.algorithms, planned.environment_versions)
        costs = cell_costs(planned.cells, len(planned.seeds), past)
        answer = DryRunAnswer.of(planned, costs, len(dispatcher.workers))
        return JSONResponse(answer.model_dump(mode="json"))
    sweep = store.create_sweep(
        request.name,
        request.priority,
        request.model_dump(mode="json", exclude_unset=True),
        planned.specs(),
        environment_versions=planned.environment_versions,
    )
    response.headers["Location"] = f"/api/v1/sweeps/{sweep.id}"
    return SweepAnswer.of(sweep)


@router.get("")
def list_sweeps(
    page: Annotated[PageQuery, Query()], request: Request, response: Response, store: TheStore
) -> Page[SweepAnswer]:
    """List sweeps, newest first."""
    sweeps = store.list_sweeps(read_cursor(page.after), page.limit + 1)
    return page_of([SweepAnswer.of(sweep) for sweep in sweeps], page.limit, request, response)


@router.get("/{sweep_id}")
def get_sweep(sweep: TheSweep) -> SweepAnswer:
    """Show a sweep: its status, counts of runs, progress."""
    return SweepAnswer.of(sweep)


@router.post("/{sweep_id}/cancel", status_code=HTTPStatus.ACCEPTED)
def cancel_sweep(sweep: TheSweep, store: TheStore) -> SweepAnswer:
    """Cancel what has not ended. Again is no error; a finished sweep answers 409."""
    try:
        return SweepAnswer.of(store.cancel_sweep(sweep.id))
    except ImpossibleMoveError as refusal:
        raise ImpossibleMove(str(refusal)) from refusal
