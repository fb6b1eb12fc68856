"""Who trains what, and what waits and why."""

from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import SWEEP, FakeDispatcher, changed
from workers.messages.progress import Progress


def test_a_worker_says_what_it_trains_and_the_queue_why_it_waits(
    client: TestClient, store: Store, dispatcher: FakeDispatcher
) -> None:
    first = client.post("/api/v1/sweeps", json=SWEEP).json()
    urgent = client.post("/api/v1/sweeps", json=changed(name="urgent", priority=5)).json()
    claim = store.claim_cohort("worker-7", 60.0)
    assert claim is not None
    store.record(claim, Progress(1600))
    answer = client.get("/api/v1/workers").json()
    assert answer["problem"] is None
    [worker] = [each for each in answer["workers"] if each["name"] == "worker-7"]
    [training] = worker["training"]
    assert training["sweep_name"] == "urgent"
    assert training["sweep_id"] == urgent["id"]
    assert training["runs"] == len(claim.runs)
    assert training["first_run"] == claim.runs[0].run_id
    assert training["label"] == urgent["entries"][0]["label"]
    assert training["timestep"] == 1600
    waiting = {each["sweep_name"]: each for each in answer["waiting"]}
    assert [*waiting] == ["urgent", SWEEP["name"]]
    assert waiting["urgent"]["runs"] == urgent["runs"]["total"] - len(claim.runs)
    assert waiting[SWEEP["name"]]["sweep_id"] == first["id"]
    dispatcher.problem = "the cluster is starting"
    answer = client.get("/api/v1/workers").json()
    assert {each["reason"] for each in answer["waiting"]} == {"the cluster is starting"}


def test_a_worker_that_is_up_and_trains_nothing_is_idle(
    client: TestClient, dispatcher: FakeDispatcher
) -> None:
    dispatcher.workers = {"worker-1": False}
    answer = client.get("/api/v1/workers").json()
    assert answer["workers"] == [{"name": "worker-1", "is_busy": False, "training": []}]
    assert answer["waiting"] == []
