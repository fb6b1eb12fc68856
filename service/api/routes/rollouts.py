"""Rollouts: a run's policy acting in its task, played in the process beside the service."""

import json
from typing import Annotated

from fastapi import APIRouter, Query, Response

from service.api.access.authority import MAY_READ
from service.api.context import TheRun, TheStore, find_run
from service.api.learned import Learned, TheLearned
from service.api.refusals.problems import Fault, InvalidRequest
from service.api.schemas.rollout_answer import RolloutAnswer, RolloutQuery, RolloutRequest
from service.model.run import Run
from workers.policies.start_error import StartError

router = APIRouter(tags=["runs"], dependencies=[MAY_READ])


@router.get("/runs/{run_id}/rollout", response_model=RolloutAnswer)
def get_rollout(
    run: TheRun, query: Annotated[RolloutQuery, Query()], learned: TheLearned
) -> Response:
    """Play an episode of a run's policy, from a start that its task draws.

    409 while the run has no policy: one is written with every checkpoint and at the end. `mpc`
    learns none.
    """
    return _played(run, query.seed, learned)


@router.post("/rollouts", response_model=RolloutAnswer)
def play_rollout(request: RolloutRequest, store: TheStore, learned: TheLearned) -> Response:
    """Play an episode of a run's policy, from a start that the request states."""
    return _played(find_run(request.run, store), list(request.start), learned)


def _played(run: Run, start: list[float] | int, learned: Learned) -> Response:
    try:
        answer = learned.call("workers.policies.rollout:rollout", run, start)
    except StartError as refusal:
        raise InvalidRequest([Fault("start", str(refusal))]) from refusal
    return Response(json.dumps(answer, allow_nan=False), media_type="application/json")
