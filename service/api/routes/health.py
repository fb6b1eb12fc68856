"""Liveness, readiness, and metrics for Prometheus.

Metrics need a token, as other routes do.
"""

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, generate_latest
from pydantic import BaseModel, Field
from sqlalchemy.exc import SQLAlchemyError

from service.api.access.authority import MAY_READ, MAY_SCRAPE, OPEN
from service.api.context import TheEventFeed, TheStore, TheWorkforce
from service.api.schemas.readiness_answer import CheckAnswer, ReadinessAnswer
from service.metrics import REGISTRY, PresentState
from service.store.store import Store
from service.store.upkeep.trouble import explain

router = APIRouter(tags=["health"])


class HealthAnswer(BaseModel):
    """The process answers."""

    status: str = Field(default="ok", examples=["ok"])


@router.get("/healthz", dependencies=[OPEN])
async def healthz() -> HealthAnswer:
    """Answer from the event loop alone: neither database nor thread pool can hold it up."""
    return HealthAnswer()


@router.get("/readyz", responses={503: {"model": ReadinessAnswer}}, dependencies=[MAY_READ])
def readyz(response: Response, store: TheStore, workforce: TheWorkforce) -> ReadinessAnswer:
    """Say whether the database answers and the cluster takes runs, and if not, why."""
    problems = {"database": _database_problem(store), "cluster": workforce.problem}
    is_ready = not any(problems.values())
    response.status_code = 200 if is_ready else 503
    return ReadinessAnswer(
        status="ready" if is_ready else "not ready",
        checks=[
            CheckAnswer(name=name, is_ready=problem is None, problem=problem)
            for name, problem in problems.items()
        ],
    )


@router.get(
    "/metrics",
    dependencies=[MAY_SCRAPE],
    response_class=Response,
    responses={200: {"content": {"text/plain": {"example": 'd3pg_runs{status="queued"} 16.0\n'}}}},
)
def get_metrics_of_service(
    store: TheStore, workforce: TheWorkforce, feed: TheEventFeed
) -> Response:
    """Answer queue, workers, latencies and traffic in Prometheus' text format."""
    present = CollectorRegistry()
    present.register(PresentState(store, workforce.workers, feed.listeners))
    text = generate_latest(present) + generate_latest(REGISTRY)
    return Response(text, media_type=CONTENT_TYPE_LATEST)


def _database_problem(store: Store) -> str | None:
    try:
        store.check()
    except SQLAlchemyError as error:
        return explain(error)
    return None
