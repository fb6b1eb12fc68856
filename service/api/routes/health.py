"""Is the process there; can it work."""

from fastapi import APIRouter, Response
from pydantic import BaseModel, Field
from sqlalchemy.exc import SQLAlchemyError

from service.api.routes.context import TheDispatcher, TheStore
from service.api.schemas.readiness_answer import CheckAnswer, ReadinessAnswer
from service.store.store import Store
from service.store.upkeep.trouble import explain

router = APIRouter(tags=["health"])


class HealthAnswer(BaseModel):
    """The process answers."""

    status: str = Field(default="ok", examples=["ok"])


@router.get("/healthz")
async def healthz() -> HealthAnswer:
    """Answer from the event loop alone: neither database nor thread pool can hold it up."""
    return HealthAnswer()


@router.get("/readyz", responses={503: {"model": ReadinessAnswer}})
def readyz(response: Response, store: TheStore, dispatcher: TheDispatcher) -> ReadinessAnswer:
    """Say whether the database answers and the cluster takes runs, and if not, why."""
    problems = {"database": _database_problem(store), "cluster": dispatcher.problem}
    is_ready = not any(problems.values())
    response.status_code = 200 if is_ready else 503
    return ReadinessAnswer(
        status="ready" if is_ready else "not ready",
        checks=[
            CheckAnswer(name=name, is_ready=problem is None, problem=problem)
            for name, problem in problems.items()
        ],
    )


def _database_problem(store: Store) -> str | None:
    try:
        store.check()
    except SQLAlchemyError as error:
        return explain(error)
    return None
