"""Runs: those of a sweep, one of them, its attempts, cancelling it."""

import math
from typing import Annotated

import numpy as np
import structlog
from fastapi import APIRouter, Query, Request, Response
from pydantic import Field

from service.api.access.authority import MAY_READ
from service.api.context import TheCheckpoints, TheLabel, TheRun, TheStore, TheSweep
from service.api.revalidation import TaggedRoute
from service.api.schemas.number import finite_or_none, numbers
from service.api.schemas.page import Page, PageQuery, page_of, read_cursor
from service.api.schemas.requests.texts import Name
from service.api.schemas.run_answer import AttemptAnswer, ListedRunAnswer, RunAnswer
from service.model.environment import best_return
from service.model.request.entry import Entries
from service.model.run import RunStatus
from service.model.sweep import Sweep
from service.store.reading.run_order import By, RunOrder, Scales
from service.store.store import Store
from workers.checkpoints.checkpoint_folder import has_policy

router = APIRouter(tags=["runs"], route_class=TaggedRoute, dependencies=[MAY_READ])
log = structlog.get_logger(__name__)


class RunQuery(PageQuery):
    """Which runs of a sweep."""

    status: RunStatus | None = None
    algorithm: Name | None = None
    environment: Name | None = Field(default=None, description="The exact name of an environment.")
    sort: By = Field(default="made", description="Runs without the value come last.")
    descending: bool = False
    sparkline: int = Field(
        default=0, ge=0, le=200, description="Number of points of return_mean with each run, about."
    )


@router.get("/sweeps/{sweep_id}/runs")
def list_runs(
    sweep: TheSweep,
    query: Annotated[RunQuery, Query()],
    request: Request,
    response: Response,
    store: TheStore,
) -> Page[ListedRunAnswer]:
    """List the runs of a sweep, in the order they were made or by a value."""
    scales = _scales(sweep, store)
    runs = store.list_runs(
        sweep.id,
        status=query.status,
        algorithm=query.algorithm,
        environment=query.environment,
        order=RunOrder(query.sort, query.descending, scales),
        after=read_cursor(query.after),
        limit=query.limit + 1,
    )
    label = Entries(sweep.request).label
    answers = [ListedRunAnswer.of(run, label(run)) for run in runs]
    page = page_of(answers, query.limit, request, response)
    for run, answer in zip(runs, page.items, strict=False):
        start, unit = scales.get(answer.environment, (math.nan, 1.0))
        answer.score = finite_or_none((run.score - start) / unit)
    if query.sparkline:
        outlines = store.return_outlines([run.id for run in page.items], query.sparkline)
        for answer in page.items:
            answer.sparkline = numbers(np.array(outlines.get(answer.id, [])))
    return page


def _scales(sweep: Sweep, store: Store) -> Scales:
    """Return the normalised scales of a sweep's environments, as far as they are known."""
    newest = {name: zero for (name, _), zero in sorted(store.random_returns().items())}
    return {
        name: (newest[name].mean, best_return(name) - newest[name].mean)
        for name in sweep.request["environments"]
        if name in newest
    }


@router.get("/runs/{run_id}")
def get_run(run: TheRun, label: TheLabel, checkpoints: TheCheckpoints) -> RunAnswer:
    """Show a run; its links have `rollout` and `policy` if it has a policy."""
    answer = RunAnswer.of(run, label)
    try:
        can_act = has_policy(checkpoints, run.id)
    except OSError as trouble:
        log.warning("whether a run has a policy cannot be seen", reason=trouble.strerror)
        can_act = False
    if can_act:
        for name in ("rollout", "policy"):
            answer.links[name] = f"{answer.links['self']}/{name}"
    return answer


@router.get("/runs/{run_id}/attempts")
def list_attempts(run: TheRun, store: TheStore) -> list[AttemptAnswer]:
    """List the attempts of a run, the first one first, and how each ended."""
    return [AttemptAnswer.of(attempt) for attempt in store.attempts(run.id)]
