"""Rollouts: a run's policy acting in its task, played in the process beside the service."""

import json
from typing import Annotated

from fastapi import APIRouter, Query, Response

from service.api.context import TheCheckpoints, TheRun, TheSide, TheStore, find_run
from service.api.learned import no_policy, other_version
from service.api.problems import Fault, ImpossibleMove, InvalidRequest, ServiceBusy
from service.api.schemas.rollout_answer import RolloutAnswer, RolloutQuery, RolloutRequest
from service.api.side_process import BusyError, Side, TooSlowError
from service.model.run import Run
from workers.checkpoints.folder import UnavailableError
from workers.checkpoints.place import Place
from workers.checkpoints.sealed_file import DamagedError
from workers.policies.start_error import StartError

router = APIRouter(tags=["runs"])


@router.get("/runs/{run_id}/rollout", response_model=RolloutAnswer)
def get_rollout(
    run: TheRun,
    query: Annotated[RolloutQuery, Query()],
    checkpoints: TheCheckpoints,
    side: TheSide,
) -> Response:
    """Play an episode of what a run has learned, from a start that its task draws.

    409 while it has learned nothing that was written: a policy is written with every checkpoint
    and at the end. `mpc` learns none.
    """
    return _played(run, query.seed, checkpoints, side)


@router.post("/rollouts", response_model=RolloutAnswer)
def play_rollout(
    request: RolloutRequest, store: TheStore, checkpoints: TheCheckpoints, side: TheSide
) -> Response:
    """Play an episode of what a run has learned, from a start of one's own."""
    return _played(find_run(request.run, store), list(request.start), checkpoints, side)


def _played(run: Run, start: list[float] | int, checkpoints: Place, side: Side) -> Response:
    if sentence := other_version(run):
        raise ImpossibleMove(sentence)
    try:
        answer = side.call("workers.policies.rollout:rollout", checkpoints, run.id, run.spec, start)
    except StartError as refusal:
        raise InvalidRequest([Fault("start", str(refusal))]) from refusal
    except UnavailableError as trouble:
        raise ServiceBusy(
            f"What run {run.id} learned cannot be read now: {trouble.strerror}."
        ) from trouble
    except DamagedError as damage:
        raise ImpossibleMove(f"What run {run.id} learned cannot be read: {damage}.") from damage
    except (BusyError, TooSlowError, EOFError) as error:
        raise ServiceBusy(f"The episode could not be played: {error}.") from error
    if answer is None:
        raise ImpossibleMove(no_policy(run))
    return Response(json.dumps(answer, allow_nan=False), media_type="application/json")
