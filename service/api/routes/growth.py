"""Adding seeds, entries or timesteps to a sweep, or a dry run of it."""

from http import HTTPStatus

from fastapi import APIRouter
from fastapi.responses import JSONResponse

from service.api.access.authority import MAY_SUBMIT
from service.api.context import TheStore, TheSweep, TheWorkerMemory, TheWorkforce
from service.api.refusals.problems import refusing
from service.api.routes.submissions import DRY_RUN, DryRun, estimate
from service.api.schemas.requests.growth import GrowthRequest
from service.api.schemas.sweep_answer import SweepAnswer
from service.api.submission.growth import growth_plan, posted_algorithms
from service.model.environment import environment_facts
from service.model.request.growth import with_algorithms
from service.model.request.plan import Plan
from service.model.sweep import Sweep
from service.store.store import Store

router = APIRouter(prefix="/sweeps/{sweep_id}", tags=["sweeps"], dependencies=[MAY_SUBMIT])


@router.post(
    "/runs", status_code=HTTPStatus.ACCEPTED, response_model=SweepAnswer, responses=DRY_RUN
)
def add_runs(
    sweep: TheSweep,
    request: GrowthRequest,
    store: TheStore,
    workforce: TheWorkforce,
    worker_memory: TheWorkerMemory,
    dry_run: DryRun = False,
) -> SweepAnswer | JSONResponse:
    """Add seeds to every curve or entries to every task, or extend every run to more timesteps.

    409 for a sweep that was cancelled; for more timesteps also while runs are in training, or if a
    learner cannot go on from where it ended. With `dry_run`, an extension counts the timesteps that
    would be added.
    """
    planned = growth_plan(sweep, store.sweep_cells(sweep.id), request, worker_memory)
    if dry_run:
        is_longer = request.timesteps is not None
        refusing(
            lambda: store.refuse_growth(sweep.id, sweep.request, _version, is_longer=is_longer)
        )
        return estimate(planned, store, workforce)
    return SweepAnswer.of(refusing(lambda: _grown(sweep, request, planned, store)))


def _grown(sweep: Sweep, request: GrowthRequest, planned: Plan, store: Store) -> Sweep:
    if request.seeds is not None:
        return store.add_seeds(sweep.id, sweep.request, request.seeds, _version)
    if request.timesteps is not None:
        return store.extend_sweep(sweep.id, sweep.request, request.timesteps, _version)
    whole = with_algorithms(sweep.request, posted_algorithms(request))
    return store.add_entries(
        sweep.id, sweep.request, whole, planned.specs(), planned.places(), _version
    )


def _version(environment: str) -> int:
    return environment_facts(environment).version
