"""A task of a file on a cluster: the service's text is what runs, whatever lies on a worker's node.

The node has folders of its own: where it was started lies another file of the same name, and its
cache is not the service's. All on loopback.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import algorithms
from physics.task_file import TaskFile
from service.api.schemas.measured.measurements_answer import table
from tests.end_to_end.curves import curves_at_the_end, wait_for, without_times
from tests.end_to_end.machine import Machine, short_folder
from tests.end_to_end.ray_node import HEALTH_CHECKS, cluster_environment, head, worker
from tests.end_to_end.running_service import RunningService, free_port, running_service
from tests.end_to_end.test_cluster import ray_token
from tests.physics.test_task_file import ARM

pytestmark = pytest.mark.cluster

TIMESTEPS = 800
OTHER = ARM.replace("stiffness = Parameter(1.0", "stiffness = Parameter(3.0")
SWEEP: dict[str, Any] = {
    "name": "my arm",
    "algorithms": [{"name": "ddpg"}],
    "environments": ["Arm"],
    "seeds": 1,
    "timesteps": TIMESTEPS,
}


@dataclass(frozen=True)
class Cluster:
    """A head without cores, a node with one, and a service that has joined them."""

    service: RunningService
    own: TaskFile
    """As the service was given it."""
    cache: Path
    """Of the node."""


def cache_of_its_own(folder: Path) -> Path:
    """A cache that has this machine's kernels, which take a minute to compile, and nothing else."""
    cache = folder / "d3pg"
    cache.mkdir(parents=True)
    (cache / "kernels").symlink_to(Path("~/.cache/d3pg/kernels").expanduser())
    return folder


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    folder = tmp_path_factory.mktemp("cluster")
    file = folder / "given" / "my_tasks.py"
    file.parent.mkdir()
    file.write_text(ARM)
    port = free_port()
    address = f"127.0.0.2:{port}"
    told = cluster_environment(address, ray_token(folder))
    environment = {name: told[name] for name in told.keys() - HEALTH_CHECKS}  # no node dies here
    with short_folder() as machines:
        cache = cache_of_its_own(machines / "cache")
        there = environment | {"XDG_CACHE_HOME": str(cache)}
        first = head(Machine(machines / "head", "127.0.0.2"), port, environment)
        node = worker(Machine(machines / "node", "127.0.0.3"), address, there)
        try:
            for each in (first, node):
                wait_for(each.keep_up)
            joined = {
                "D3PG_RAY_ADDRESS": address,
                "D3PG_MIN_WORKERS": "1",
                "D3PG_TASKS": str(file),
            }
            with running_service(folder, environment | joined) as (service, _):
                wait_for(lambda: node.has_worker)
                yield Cluster(service, TaskFile.read(file), cache)
        finally:
            for each in (first, node):
                each.machine.kill()


def test_the_text_of_the_service_runs_on_a_node_and_another_one_is_refused(
    cluster: Cluster,
) -> None:
    client, own = cluster.service.client, cluster.own
    Path(cluster.service.environment["D3PG_TASKS"]).write_text(OTHER)  # it has been read before
    sweep_id = client.submit(SWEEP).id
    found = curves_at_the_end(client, sweep_id)
    task = own.reference("Arm")
    trained = table(list(algorithms.train("ddpg", task, [0], timesteps=TIMESTEPS)))
    assert found == {("ddpg", "Arm", 0): without_times(trained)}
    (run,) = client.runs(sweep_id)
    assert run.fingerprint is not None
    assert run.fingerprint["task"] == own.digest

    there = cluster.cache / "d3pg" / "tasks" / own.digest / own.name
    assert there.read_text() == ARM  # it came with the work
    there.write_text(OTHER)
    again = client.submit({**SWEEP, "name": "changed on the node"}).id
    ended = client.wait(again, timeout_seconds=300.0)
    assert ended.runs.failed == ended.runs.total == 1
    (run,) = client.runs(again)
    assert f"has the hash {TaskFile(own.name, OTHER).digest}, but the service's" in run.reason
    assert "remove the file there, and retry the run" in run.reason

    there.unlink()
    client.retry(again)
    assert curves_at_the_end(client, again) == found
