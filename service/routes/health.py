"""Is the process there; can it work."""

from fastapi import APIRouter, Response
from pydantic import BaseModel, ConfigDict
from sqlalchemy.exc import SQLAlchemyError

from service.routes.context import TheDispatcher, TheStore
from service.store.store import Store

router = APIRouter(tags=["health"])


class HealthAnswer(BaseModel):
    """The process answers."""

    status: str = "ok"


class CheckAnswer(BaseModel):
    """One thing the service needs; `problem` is a sentence, null while there is none."""

    name: str
    is_ready: bool
    problem: str | None


class ReadinessAnswer(BaseModel):
    """Whether runs can be stored and started."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "status": "not ready",
                    "checks": [
                        {"name": "database", "is_ready": True, "problem": None},
                        {"name": "cluster", "is_ready": False, "problem": "cluster starting"},
                    ],
                }
            ]
        }
    )

    status: str
    checks: list[CheckAnswer]


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
        return f"the database does not answer: {error}"
    return None
