"""Dispatch: the cost of a run beyond its own work, and the service's response time meanwhile.

A run's overhead is the time from its claim to its recorded end, both by the database's clock, minus
the processor time that its learner reported for training and for loading kernels. Its one
evaluation, about 5 ms, counts as overhead. The runs have 800 timesteps and train one after the
other on a warm worker of a real service. The peer, in the same run, is a Ray task that does
nothing, on a warm worker and on a new one each time.
"""

import logging
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
import ray

from service.client import Client
from tests.end_to_end.running_service import running_service

RUNS = 40
TASKS = 200
NEW_WORKERS = 5
ASKED_SECONDS = 30.0
PAUSE_SECONDS = 0.01
SMALL = {
    "name": "small",
    "algorithms": [{"name": "ddpg"}],
    "environments": ["Pendulum"],
    "seeds": 1,
    "timesteps": 800,
}
ENDLESS = SMALL | {"name": "endless", "seeds": 32, "timesteps": 10_000_000}


def main() -> None:
    """Print every figure."""
    with tempfile.TemporaryDirectory() as folder, running_service(Path(folder)) as (_, client):
        run_overhead(client)  # the kernels are compiled, the random return is measured
        ours = sorted(run_overhead(client) for _ in range(RUNS))
        waits = sorted(healthz_waits(client))
    report("a run's overhead, median", statistics.median(ours), "s")
    report(f"a run's overhead, longest of {RUNS}", ours[-1], "s")
    report("/healthz while two workers train, median", 1000 * statistics.median(waits), "ms")
    report("/healthz while two workers train, p99", 1000 * waits[int(0.99 * len(waits))], "ms")
    warm, new = ray_seconds()
    report("Ray, a task that does nothing, median", statistics.median(warm), "s")
    report("Ray, the same on a new worker each time, median", statistics.median(new), "s")


def run_overhead(client: Client) -> float:
    """The seconds from claim to recorded end of a single run, minus the learner's work."""
    sweep_id = client.submit(SMALL).id
    client.wait(sweep_id, timeout_seconds=240)
    [run] = client.runs(sweep_id)
    [attempt] = client.attempts(run.id)
    assert attempt.ended_at is not None
    columns = client.measurements(run.id).columns
    own_work = sum(columns[name][-1] or 0.0 for name in ("seconds", "compile_seconds"))
    return (attempt.ended_at - attempt.started_at).total_seconds() - own_work


def healthz_waits(client: Client) -> list[float]:
    """The seconds of each answer while both workers train."""
    sweep_id = client.submit(ENDLESS).id
    while sum(run.timestep > 0 for run in client.runs(sweep_id)) < 32:
        time.sleep(0.1)
    waits = []
    deadline = time.monotonic() + ASKED_SECONDS
    with httpx2.Client(base_url=client.url) as stranger:
        while time.monotonic() < deadline:
            begun = time.perf_counter()
            assert stranger.get("/healthz").status_code == 200
            waits.append(time.perf_counter() - begun)
            time.sleep(PAUSE_SECONDS)
    client.move(sweep_id, "cancel")
    return waits


def ray_seconds() -> tuple[list[float], list[float]]:
    """The seconds of a task that does nothing, until its result: on a warm worker, on a new one."""
    with local_ray():
        idle: Any = ray.remote(_nothing)
        call_seconds(idle)
        warm = [call_seconds(idle) for _ in range(TASKS)]
        alone: Any = ray.remote(max_calls=1)(_nothing)  # its worker ends with it
        return warm, [call_seconds(alone) for _ in range(NEW_WORKERS)]


def call_seconds(task: Any) -> float:
    begun = time.perf_counter()
    ray.get(task.remote())
    return time.perf_counter() - begun


@contextmanager
def local_ray() -> Iterator[None]:
    """A Ray of our own with two workers."""
    ray.init(address="local", num_cpus=2, include_dashboard=False, logging_level=logging.ERROR)
    try:
        yield
    finally:
        ray.shutdown()


def _nothing() -> None:
    return


def report(name: str, value: float, unit: str) -> None:
    print(f"{name}: {value:,.3g} {unit}", flush=True)


if __name__ == "__main__":
    main()
