"""Moves: cancelling, pausing, resuming and retrying, of sweeps and of runs.

A repeated move changes nothing and is not an error. A move that is not possible answers 409 with
the reason.
"""

from collections.abc import Callable, Sequence
from http import HTTPStatus

from fastapi import APIRouter

from service.api.access.authority import MAY_SUBMIT, not_theirs
from service.api.context import TheCaller, TheLabel, TheRun, TheStore, TheSweep, may_be_id
from service.api.refusals.problems import refusing
from service.api.schemas.requests.bulk import (
    BulkAnswer,
    BulkRequest,
    DeletionAnswer,
    RefusalAnswer,
)
from service.api.schemas.run_answer import RunAnswer
from service.api.schemas.sweep_answer import SweepAnswer
from service.model.caller import Caller
from service.model.move import TRANSITIONS, Move
from service.model.run import Run
from service.model.run_name import RunName
from service.model.sweep import Sweep
from service.store.store import Store

router = APIRouter(dependencies=[MAY_SUBMIT])
sweeps = APIRouter(prefix="/sweeps/{sweep_id}", tags=["sweeps"])
runs = APIRouter(prefix="/runs/{run_id}", tags=["runs"])


@router.post("/moves", tags=["sweeps"], status_code=HTTPStatus.ACCEPTED)
def move_many(request: BulkRequest, caller: TheCaller, store: TheStore) -> BulkAnswer:
    """Move many sweeps and runs at once; the answer says why others could not be moved."""
    others = _of_others(request.ids, caller, store)
    asked = [each for each in request.ids if each not in others]
    reasons = others | {each.id: each.reason for each in store.move_all(request.move, asked)}
    return BulkAnswer(
        moved=[each for each in request.ids if each not in reasons],
        refused=[
            RefusalAnswer(id=each, reason=reasons[each]) for each in request.ids if each in reasons
        ],
    )


def _of_others(identifiers: Sequence[str], caller: Caller, store: Store) -> dict[str, str]:
    """Return why the caller may not move some of the sweeps and runs."""
    names = {each: RunName.parse(each).sweep_id for each in identifiers if may_be_id(each)}
    owners = store.sweep_owners(set(names.values()))
    return {
        each: not_theirs(sweep_id, owners[sweep_id])
        for each, sweep_id in names.items()
        if sweep_id in owners and not caller.may_change(owners[sweep_id])
    }


@router.delete("/sweeps/{sweep_id}", tags=["sweeps"], status_code=HTTPStatus.ACCEPTED)
def delete_sweep(sweep: TheSweep, store: TheStore) -> DeletionAnswer:
    """Delete a sweep that has ended, with its measurements and policies, for good."""
    return DeletionAnswer(id=sweep.id, runs=refusing(lambda: store.delete_sweep(sweep.id)))


def _move_of_sweep(asked: Move) -> Callable[[Sweep, Store], SweepAnswer]:
    def move(sweep: TheSweep, store: TheStore) -> SweepAnswer:
        return SweepAnswer.of(refusing(lambda: store.move_sweep(sweep.id, asked)))

    return move


def _move_of_run(asked: Move) -> Callable[[Run, str, Store], RunAnswer]:
    def move(run: TheRun, label: TheLabel, store: TheStore) -> RunAnswer:
        return RunAnswer.of(refusing(lambda: store.move_run(run.id, asked)), label)

    return move


for asked, transition in TRANSITIONS.items():
    sweeps.post(
        f"/{asked}",
        name=f"{asked}_sweep",
        description=transition.of_sweep.description,
        status_code=HTTPStatus.ACCEPTED,
    )(_move_of_sweep(asked))
    runs.post(
        f"/{asked}",
        name=f"{asked}_run",
        description=transition.of_run.description,
        status_code=HTTPStatus.ACCEPTED,
    )(_move_of_run(asked))
for resource in (sweeps, runs):
    router.include_router(resource)
