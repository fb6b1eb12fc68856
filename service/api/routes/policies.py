"""Policies: what a run has learned, as a file to act with."""

from typing import Any

from fastapi import APIRouter, Response

from service.api.access.authority import MAY_READ
from service.api.context import TheRun
from service.api.learned import TheLearned

router = APIRouter(tags=["runs"], dependencies=[MAY_READ])

MEDIA_TYPE = "application/octet-stream"
EXAMPLE = "The bytes of a NumPy archive: header, mean, inverse_std, hidden/0/weight, ..."
ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "A NumPy archive, .npz: the header, a JSON text, and the networks' arrays.",
        "content": {MEDIA_TYPE: {"example": EXAMPLE}},
    }
}


@router.get("/runs/{run_id}/policy", response_class=Response, responses=ANSWERS)
def get_policy(run: TheRun, learned: TheLearned) -> Response:
    """Download the policy that a run has learned, as of its last checkpoint or its end.

    The file is a NumPy archive, which `algorithms.load_policy` reads, and any program that reads
    NumPy's format without pickle. 409 while no policy of the run was written, and for `mpc`,
    which learns none.
    """
    content = learned.call("workers.policies.policy_file:policy_file", run)
    disposition = f'attachment; filename="{run.id}.npz"'
    return Response(content, media_type=MEDIA_TYPE, headers={"Content-Disposition": disposition})
