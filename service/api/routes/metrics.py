"""Metrics for Prometheus; the token is asked for here as everywhere."""

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, generate_latest

from service.api.routes.context import TheDispatcher, TheEventFeed, TheStore
from service.metrics import REGISTRY, Standing

router = APIRouter(tags=["health"])


@router.get(
    "/metrics",
    response_class=Response,
    responses={200: {"content": {"text/plain": {"example": 'd3pg_runs{status="queued"} 16.0\n'}}}},
)
def get_metrics_of_service(
    store: TheStore, dispatcher: TheDispatcher, feed: TheEventFeed
) -> Response:
    """Answer queue, workers, latencies and traffic in Prometheus' text format."""
    standing = CollectorRegistry()
    standing.register(Standing(store, dispatcher.workers, feed.listeners))
    text = generate_latest(standing) + generate_latest(REGISTRY)
    return Response(text, media_type=CONTENT_TYPE_LATEST)
