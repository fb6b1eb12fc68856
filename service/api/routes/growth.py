"""Adding to a sweep: seeds, entries, timesteps."""

from http import HTTPStatus

from fastapi import APIRouter

from service.api.access.authority import MAY_SUBMIT
from service.api.context import TheStore, TheSweep, TheWorkerMemory
from service.api.refusals.problems import refusing
from service.api.schemas.requests.growth import GrowthRequest
from service.api.schemas.sweep_answer import SweepAnswer
from service.api.submission.growth import check_seeds, check_timesteps, plan_entries
from service.model.environment import environment_facts
from service.model.request.growth import with_algorithms
from service.model.sweep import Sweep
from service.store.store import Store

router = APIRouter(prefix="/sweeps/{sweep_id}", tags=["sweeps"], dependencies=[MAY_SUBMIT])


@router.post("/runs", status_code=HTTPStatus.ACCEPTED)
def add_runs(
    sweep: TheSweep, request: GrowthRequest, store: TheStore, worker_memory: TheWorkerMemory
) -> SweepAnswer:
    """Add seeds to every curve or entries to every task, or extend every run to more timesteps.

    409 for a sweep that was cancelled, for more timesteps also while runs are in training or where
    a learner cannot go on from where it ended.
    """
    return SweepAnswer.of(refusing(lambda: _grown(sweep, request, store, worker_memory)))


def _grown(sweep: Sweep, request: GrowthRequest, store: Store, worker_memory: int) -> Sweep:
    cells = store.sweep_cells(sweep.id)
    if request.seeds is not None:
        check_seeds(sweep, cells, request.seeds)
        return store.add_seeds(sweep.id, sweep.request, request.seeds, _version)
    if request.timesteps is not None:
        check_timesteps(sweep, cells, request.timesteps, worker_memory)
        return store.extend_sweep(sweep.id, sweep.request, request.timesteps, _version)
    posted = request.model_dump(mode="json", exclude_unset=True)["algorithms"]
    added = plan_entries(sweep, posted, worker_memory)
    whole = with_algorithms(sweep.request, posted)
    return store.add_entries(
        sweep.id, sweep.request, whole, added.specs(), added.places(), _version
    )


def _version(environment: str) -> int:
    return environment_facts(environment).version
