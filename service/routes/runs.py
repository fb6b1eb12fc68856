"""Runs: those of a sweep, one of them, cancelling it, what it measured."""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic import Field

from service.problems import ImpossibleMove
from service.routes.context import TheRun, TheStore, TheSweep
from service.run import RunStatus
from service.schemas.page import Page, PageQuery, page_of, read_cursor
from service.schemas.run_answer import RunAnswer
from service.schemas.sweep_request import Name
from service.store.refusal import ImpossibleMoveError

router = APIRouter(tags=["runs"])


class RunQuery(PageQuery):
    """Which runs of a sweep."""

    status: RunStatus | None = None
    algorithm: Name | None = None
    environment: Name | None = Field(default=None, description="Its exact name.")


@router.get("/sweeps/{sweep_id}/runs")
def list_runs(
    sweep: TheSweep,
    query: Annotated[RunQuery, Query()],
    request: Request,
    response: Response,
    store: TheStore,
) -> Page[RunAnswer]:
    """List the runs of a sweep, in the order they were made."""
    runs = store.list_runs(
        sweep.id,
        status=query.status,
        algorithm=query.algorithm,
        environment=query.environment,
        after=read_cursor(query.after),
        limit=query.limit + 1,
    )
    return page_of([RunAnswer.of(run) for run in runs], query.limit, request, response)


@router.get("/runs/{run_id}")
def get_run(run: TheRun) -> RunAnswer:
    """Show a run."""
    return RunAnswer.of(run)


@router.post("/runs/{run_id}/cancel", status_code=HTTPStatus.ACCEPTED)
def cancel_run(run: TheRun, store: TheStore) -> RunAnswer:
    """Cancel a run. Again is no error; one that ended otherwise answers 409."""
    try:
        return RunAnswer.of(store.cancel_run(run.id))
    except ImpossibleMoveError as refusal:
        raise ImpossibleMove(str(refusal)) from refusal
