"""Rollouts: a run's policy acting in its task, played in the process beside the service."""

import json
from typing import Annotated

from fastapi import APIRouter, Query, Response

from service.api.context import TheCheckpoints, TheRun, TheShelf, TheSide, TheStore, find_run
from service.api.learned import learned
from service.api.problems import Fault, InvalidRequest
from service.api.schemas.rollout_answer import RolloutAnswer, RolloutQuery, RolloutRequest
from service.api.side_process import Side
from service.model.run import Run
from service.task_shelf import TaskShelf
from workers.checkpoints.place import Place
from workers.policies.start_error import StartError

router = APIRouter(tags=["runs"])


@router.get("/runs/{run_id}/rollout", response_model=RolloutAnswer)
def get_rollout(
    run: TheRun,
    query: Annotated[RolloutQuery, Query()],
    checkpoints: TheCheckpoints,
    side: TheSide,
    shelf: TheShelf,
) -> Response:
    """Play an episode of what a run has learned, from a start that its task draws.

    409 while it has learned nothing that was written: a policy is written with every checkpoint
    and at the end. `mpc` learns none.
    """
    return _played(run, query.seed, checkpoints, side, shelf)


@router.post("/rollouts", response_model=RolloutAnswer)
def play_rollout(
    request: RolloutRequest,
    store: TheStore,
    checkpoints: TheCheckpoints,
    side: TheSide,
    shelf: TheShelf,
) -> Response:
    """Play an episode of what a run has learned, from a start of one's own."""
    return _played(find_run(request.run, store), list(request.start), checkpoints, side, shelf)


def _played(
    run: Run, start: list[float] | int, checkpoints: Place, side: Side, shelf: TaskShelf
) -> Response:
    try:
        answer = learned(side, "workers.policies.rollout:rollout", checkpoints, run, shelf, start)
    except StartError as refusal:
        raise InvalidRequest([Fault("start", str(refusal))]) from refusal
    return Response(json.dumps(answer, allow_nan=False), media_type="application/json")
