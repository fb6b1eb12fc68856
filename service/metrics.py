"""Metrics for Prometheus: the state of the queue, and how fast its parts are.

Values in the database or in memory are read on each request; durations and counts are recorded as
they happen, for this process since it started.
"""

from collections.abc import Iterator, Mapping
from typing import Protocol

from prometheus_client import CollectorRegistry, Counter, Histogram
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.metrics_core import Metric
from prometheus_client.registry import Collector

REGISTRY = CollectorRegistry()
SECONDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10)

WRITE_SECONDS = Histogram(
    "d3pg_store_write_seconds",
    "From handing a unit of work to the one writer to its commit.",
    buckets=SECONDS,
    registry=REGISTRY,
)
DISPATCH_SECONDS = Histogram(
    "d3pg_dispatch_round_seconds",
    "A round of dispatch, without its wait for reports.",
    buckets=SECONDS,
    registry=REGISTRY,
)
MEASUREMENTS = Counter(
    "d3pg_measurements_ingested",
    "Measurements in reports of workers that were written; those sent twice count twice.",
    registry=REGISTRY,
)
FREED_BYTES = Counter(
    "d3pg_freed_bytes",
    "Bytes of files that were older than they are kept.",
    ["kind"],
    registry=REGISTRY,
)
FREED_ROWS = Counter(
    "d3pg_freed_rows",
    "Rows of deleted sweeps, and of events that were older than they are kept.",
    ["kind"],
    registry=REGISTRY,
)
HTTP_SECONDS = Histogram(
    "d3pg_http_request_seconds",
    "From a request to the start of its answer.",
    ["method", "route", "status"],
    buckets=SECONDS,
    registry=REGISTRY,
)


class Counts(Protocol):
    """The queries on the store."""

    def count_runs(self) -> Mapping[str, int]:
        """How many runs there are by status."""

    def count_attempts(self) -> Mapping[str, int]:
        """How many attempts there were by outcome."""


class PresentState(Collector):
    """The state of queue, workers and streams at the time of a request."""

    def __init__(self, counts: Counts, workers: Mapping[str, bool], streams: int) -> None:
        """`workers` says who is busy, `streams` how many event streams are open."""
        self._counts = counts
        self._workers = workers
        self._streams = streams

    def collect(self) -> Iterator[Metric]:
        """Yield the gauges."""
        runs = self._counts.count_runs()
        attempts = self._counts.count_attempts()
        busy = sum(self._workers.values())
        workers = {"busy": busy, "idle": len(self._workers) - busy}
        yield _by("status", "d3pg_runs", "Runs of all sweeps.", runs)
        yield _by("outcome", "d3pg_attempts", "Attempts of all runs.", attempts)
        yield _by("state", "d3pg_workers", "Workers that are up.", workers)
        yield GaugeMetricFamily(
            "d3pg_event_streams", "Event streams that are open.", value=self._streams
        )


def _by(label: str, name: str, text: str, values: Mapping[str, int]) -> GaugeMetricFamily:
    family = GaugeMetricFamily(name, text, labels=[label])
    for value, count in values.items():
        family.add_metric([value], count)
    return family
