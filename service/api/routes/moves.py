"""Moves: cancelling, pausing, resuming and retrying, of sweeps and of runs.

Asked again, a move changes nothing and is no error. From where it cannot start it answers 409
with the reason.
"""

from collections.abc import Callable
from http import HTTPStatus
from typing import TypeVar

from fastapi import APIRouter

from service.api.problems import ImpossibleMove
from service.api.routes.context import TheLabel, TheRun, TheStore, TheSweep
from service.api.schemas.run_answer import RunAnswer
from service.api.schemas.sweep_answer import SweepAnswer
from service.store.refusal import ImpossibleMoveError

router = APIRouter()
sweeps = APIRouter(prefix="/sweeps/{sweep_id}", tags=["sweeps"])
runs = APIRouter(prefix="/runs/{run_id}", tags=["runs"])

Moved = TypeVar("Moved")


@sweeps.post("/cancel", status_code=HTTPStatus.ACCEPTED)
def cancel_sweep(sweep: TheSweep, store: TheStore) -> SweepAnswer:
    """Cancel what has not ended; what was measured stays."""
    return SweepAnswer.of(_moved(store.cancel_sweep, sweep.id))


@sweeps.post("/pause", status_code=HTTPStatus.ACCEPTED)
def pause_sweep(sweep: TheSweep, store: TheStore) -> SweepAnswer:
    """Start none of its runs from now on; those that are running go on to their end."""
    return SweepAnswer.of(_moved(store.pause_sweep, sweep.id))


@sweeps.post("/resume", status_code=HTTPStatus.ACCEPTED)
def resume_sweep(sweep: TheSweep, store: TheStore) -> SweepAnswer:
    """Queue its paused runs, those that were paused alone too."""
    return SweepAnswer.of(_moved(store.resume_sweep, sweep.id))


@sweeps.post("/retry", status_code=HTTPStatus.ACCEPTED)
def retry_sweep(sweep: TheSweep, store: TheStore) -> SweepAnswer:
    """Queue its failed runs again, and only those; what they measured and their attempts stay."""
    return SweepAnswer.of(_moved(store.retry_sweep, sweep.id))


@runs.post("/cancel", status_code=HTTPStatus.ACCEPTED)
def cancel_run(run: TheRun, label: TheLabel, store: TheStore) -> RunAnswer:
    """Cancel a run: at once while it waits, by its worker while it runs."""
    return RunAnswer.of(_moved(store.cancel_run, run.id), label)


@runs.post("/pause", status_code=HTTPStatus.ACCEPTED)
def pause_run(run: TheRun, label: TheLabel, store: TheStore) -> RunAnswer:
    """Keep a queued run from being started."""
    return RunAnswer.of(_moved(store.pause_run, run.id), label)


@runs.post("/resume", status_code=HTTPStatus.ACCEPTED)
def resume_run(run: TheRun, label: TheLabel, store: TheStore) -> RunAnswer:
    """Queue a paused run."""
    return RunAnswer.of(_moved(store.resume_run, run.id), label)


@runs.post("/retry", status_code=HTTPStatus.ACCEPTED)
def retry_run(run: TheRun, label: TheLabel, store: TheStore) -> RunAnswer:
    """Queue a failed run again; what it measured and its attempts stay."""
    return RunAnswer.of(_moved(store.retry_run, run.id), label)


def _moved(move: Callable[[str], Moved], name: str) -> Moved:
    try:
        return move(name)
    except ImpossibleMoveError as refusal:
        text = str(refusal)
        raise ImpossibleMove(f"{text[0].upper()}{text[1:]}.") from refusal


for resource in (sweeps, runs):
    router.include_router(resource)
