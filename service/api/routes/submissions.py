"""Submitting a sweep, or a dry run of it."""

from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Response
from fastapi.responses import JSONResponse

from service.analysis.cost import cell_costs
from service.api.access.authority import MAY_SUBMIT
from service.api.context import (
    TheCaller,
    TheStore,
    TheWebhookHosts,
    TheWorkerMemory,
    TheWorkforce,
    Workforce,
)
from service.api.place import here
from service.api.refusals.problems import Fault, InvalidRequest
from service.api.schemas.requests.sweep_request import SweepRequest
from service.api.schemas.sweep_answer import DryRunAnswer, SweepAnswer
from service.api.submission.plan import plan
from service.api.submission.route import SubmissionRoute
from service.api.submission.webhook import refuse_webhook
from service.model.request.plan import Plan
from service.store.refusal import SubmissionKeyReusedError
from service.store.store import Store

router = APIRouter(
    prefix="/sweeps", tags=["sweeps"], route_class=SubmissionRoute, dependencies=[MAY_SUBMIT]
)

DryRun = Annotated[
    bool, Query(description="Queue nothing; answer what would be queued, and its estimated cost.")
]
DRY_RUN: dict[int | str, dict[str, Any]] = {
    200: {"model": DryRunAnswer, "description": "With `dry_run=true`."}
}
SubmissionKey = Annotated[
    str | None,
    Header(
        min_length=1,
        max_length=255,
        pattern=r"^[\x20-\x7e]+$",
        description="Any text, new for every sweep: it makes a retry safe.",
    ),
]


@router.post(
    "",
    status_code=HTTPStatus.ACCEPTED,
    response_model=SweepAnswer,
    responses=DRY_RUN,
)
def submit_sweep(
    request: SweepRequest,
    response: Response,
    caller: TheCaller,
    store: TheStore,
    workforce: TheWorkforce,
    worker_memory: TheWorkerMemory,
    webhook_hosts: TheWebhookHosts,
    dry_run: DryRun = False,
    idempotency_key: SubmissionKey = None,
) -> SweepAnswer | JSONResponse:
    """Queue a sweep: all of its runs in one transaction, or none.

    A second submission with the same `Idempotency-Key` answers the first sweep, for as long as that
    is kept; the same key with another request is refused.
    """
    refuse_webhook(request.webhook, webhook_hosts)
    planned = plan(request, worker_memory)
    if dry_run:
        return estimate(planned, store, workforce)
    try:
        sweep = store.create_sweep(
            request.name,
            request.priority,
            request.model_dump(mode="json", exclude_unset=True),
            planned.specs(),
            entries=planned.places(),
            notes=request.notes,
            tags=request.tags,
            max_workers=request.max_workers,
            webhook=request.webhook,
            environment_versions=planned.environment_versions,
            submission_key=idempotency_key,
            search=planned.search,
            owner=caller.name,
        )
    except SubmissionKeyReusedError as refusal:
        raise InvalidRequest([Fault("Idempotency-Key", str(refusal))]) from refusal
    response.headers["Location"] = here(f"/api/v1/sweeps/{sweep.id}")
    return SweepAnswer.of(sweep, planned.notices)


def estimate(planned: Plan, store: Store, workforce: Workforce) -> JSONResponse:
    """Answer what a plan would queue, and its estimated cost."""
    past = store.past_costs(planned.algorithms, planned.environment_versions)
    costs = cell_costs(planned.costed, len(planned.seeds), past)
    answer = DryRunAnswer.of(planned, costs, len(workforce.workers))
    return JSONResponse(answer.model_dump(mode="json"))
