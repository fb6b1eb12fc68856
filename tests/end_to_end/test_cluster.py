"""A cluster of several nodes and PostgreSQL: a sweep trains on all of them, and a node may die.

All on loopback, which needs no rights; the driver of Ray is beside the head.
"""

import secrets
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import algorithms
from service.api.schemas.measured.measurements_answer import table
from tests.end_to_end.curves import Curves, curves_at_the_end, submitted, wait_for, without_times
from tests.end_to_end.machine import Machine, short_folder
from tests.end_to_end.ray_node import Node, cluster_environment, head, worker
from tests.end_to_end.running_service import RunningService, free_port, running_service
from tests.service.store.postgresql import running_postgresql

pytestmark = pytest.mark.cluster

TIMESTEPS = 24_000
SEEDS = range(4)
SWEEP: dict[str, Any] = {
    "name": "across two nodes",
    "algorithms": [{"name": "ddpg"}],
    "environments": ["Pendulum"],
    "seeds": len(SEEDS),
    "timesteps": TIMESTEPS,
}


@dataclass(frozen=True)
class Cluster:
    """Two nodes with a core each, beside a head with none, and a service that has joined it."""

    nodes: list[Node]
    service: RunningService


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    folder = tmp_path_factory.mktemp("cluster")
    port = free_port()
    address = f"127.0.0.2:{port}"  # Ray takes 127.0.0.1 to mean an address that others reach
    environment = cluster_environment(address, ray_token(folder))
    with short_folder() as machines, running_postgresql() as database:
        first = head(Machine(machines / "head", "127.0.0.2"), port, environment)
        nodes = [
            worker(Machine(machines / "one", "127.0.0.3"), address, environment),
            worker(Machine(machines / "two", "127.0.0.4"), address, environment),
        ]
        try:
            for node in [first, *nodes]:
                wait_for(node.keep_up)
            joined = {
                "D3PG_RAY_ADDRESS": address,
                "D3PG_DATABASE_URL": database.create("d3pg"),
                "D3PG_MIN_WORKERS": str(len(nodes)),
            }
            with running_service(folder, environment | joined) as (service, _):
                wait_for(lambda: all(node.has_worker for node in nodes))
                yield Cluster(nodes, service)
        finally:
            for node in [first, *nodes]:
                node.machine.kill()


def ray_token(folder: Path) -> Path:
    """A token for Ray's processes, in a file."""
    path = folder / "cluster-token"
    path.write_text(secrets.token_hex(32))
    path.chmod(0o600)
    return path


@pytest.fixture(scope="module")
def undisturbed() -> Curves:
    """What the sweep must give: the same runs, trained in this process."""
    trained = list(algorithms.train("ddpg", "Pendulum", SEEDS, timesteps=TIMESTEPS))
    return {
        ("ddpg", "Pendulum", seed): without_times(table([m for m in trained if m.seed == seed]))
        for seed in SEEDS
    }


def test_a_sweep_across_both_nodes_goes_on_without_one_of_them(
    undisturbed: Curves,  # first: then the kernels are compiled, and both begin at once
    cluster: Cluster,
) -> None:
    client = cluster.service.client
    sweep_id = submitted(client, SWEEP)
    assert all(node.trains for node in cluster.nodes)
    cluster.nodes[0].machine.kill()
    assert curves_at_the_end(client, sweep_id) == undisturbed
    attempts = sorted(run.attempt for run in client.runs(sweep_id))
    assert attempts == [1, 1, 2, 2]
