"""Metrics in Prometheus' format: what they say of queue, workers, writes and traffic."""

from prometheus_client.parser import text_string_to_metric_families
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import SWEEP, FakeDispatcher
from tests.service.training import train


def samples(client: TestClient) -> dict[tuple[str, frozenset[str]], float]:
    """Every sample by its name and the values of its labels."""
    response = client.get("/metrics")
    assert response.status_code == 200
    assert response.headers["content-type"].startswith("text/plain; version=")
    return {
        (sample.name, frozenset(sample.labels.values())): sample.value
        for family in text_string_to_metric_families(response.text)
        for sample in family.samples
    }


def one(client: TestClient, name: str, *labels: str) -> float:
    return samples(client)[name, frozenset(labels)]


def test_the_queue_by_status(client: TestClient, store: Store) -> None:
    before = samples(client)
    for status in ("queued", "running", "succeeded", "failed", "diverged", "cancelled"):
        assert before["d3pg_runs", frozenset({status})] == 0
    client.post("/api/v1/sweeps", json=SWEEP)
    assert one(client, "d3pg_runs", "queued") == 12
    assert store.claim_cohort("worker", 60.0) is not None
    after = samples(client)
    assert after["d3pg_runs", frozenset({"running"})] == 3
    assert after["d3pg_runs", frozenset({"queued"})] == 9
    assert after["d3pg_attempts", frozenset({"running"})] == 3


def test_workers(client: TestClient, dispatcher: FakeDispatcher) -> None:
    dispatcher.workers = {"a": True, "b": False, "c": True}
    assert one(client, "d3pg_workers", "busy") == 2
    assert one(client, "d3pg_workers", "idle") == 1
    assert one(client, "d3pg_event_streams") == 0


def test_what_is_written_is_counted_and_timed(client: TestClient, store: Store) -> None:
    client.post("/api/v1/sweeps", json=SWEEP)
    ingested = one(client, "d3pg_measurements_ingested_total")
    writes = one(client, "d3pg_store_write_seconds_count")
    train(store, 5, lambda *_: 0.0)
    assert one(client, "d3pg_measurements_ingested_total") == ingested + 12 * 5
    # Four cohorts: as many claims and records, and the claim that found nothing left.
    assert one(client, "d3pg_store_write_seconds_count") == writes + 9


def test_requests_by_template_and_never_by_what_a_client_made_up(client: TestClient) -> None:
    for path in ("/api/v1/sweeps/abc", "/api/v1/sweeps/def", "/made-up"):
        client.get(path)
    client.request("BREW", "/api/v1/sweeps/abc")
    found = samples(client)
    labels = {labels for name, labels in found if name == "d3pg_http_request_seconds_count"}
    assert frozenset({"GET", "/api/v1/sweeps/{sweep_id}", "404"}) in labels
    assert frozenset({"GET", "none", "404"}) in labels
    assert not any("abc" in text or "made-up" in text or text == "BREW" for each in labels
                   for text in each)  # fmt: skip


def test_strangers_are_not_told(stranger: TestClient) -> None:
    assert stranger.get("/metrics").status_code == 401
