"""Slots on a real Ray cluster: they follow nodes that join, go and come back."""

import itertools
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests.end_to_end.curves import wait_for
from tests.end_to_end.machine import Machine, short_folder
from tests.end_to_end.ray_node import Node, cluster_environment, head, worker
from tests.end_to_end.running_service import free_port
from tests.workers.heard import ENDLESS, Heard
from workers.messages.report import Capacity, Lost, Ready, Report

pytestmark = pytest.mark.cluster

WORKER_BYTES = 500 * 2**20


@dataclass
class Cluster:
    """A head without cores, nodes with one each, and a pool that has joined."""

    machines: Path
    port: int
    environment: dict[str, str]
    heard: Heard
    ended: ExitStack
    names: "itertools.count[int]" = field(default_factory=lambda: itertools.count(3))

    def add_node(self) -> Node:
        """Have another node join."""
        number = next(self.names)
        machine = Machine(self.machines / str(number), f"127.0.0.{number}")
        node = worker(machine, f"127.0.0.2:{self.port}", self.environment)
        self.ended.callback(machine.kill)
        wait_for(node.keep_up)
        return node


@pytest.fixture
def cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    port = free_port()
    address = f"127.0.0.2:{port}"  # Ray takes 127.0.0.1 to mean an address that others reach
    token = tmp_path / "cluster-token"
    token.write_text(64 * "0")
    environment = cluster_environment(address, token)
    monkeypatch.setenv("RAY_AUTH_TOKEN_PATH", str(token))
    with short_folder() as machines, ExitStack() as ended:
        first = head(Machine(machines / "head", "127.0.0.2"), port, environment)
        ended.callback(first.machine.kill)
        cluster = Cluster(
            machines, port, environment, Heard(tmp_path, address, WORKER_BYTES), ended
        )
        wait_for(first.keep_up)
        ended.callback(cluster.heard.pool.close)
        yield cluster


def has_room_for(workers: int) -> Callable[[list[Report]], bool]:
    """Whether that is what was told last of the cluster."""

    def is_so(reports: list[Report]) -> bool:
        told = [report.workers for report in reports if isinstance(report, Capacity)]
        return told[-1:] == [workers]

    return is_so


def test_nodes_that_join_later_are_used_and_missed_when_they_go(cluster: Cluster) -> None:
    heard = cluster.heard
    heard.start_pool()
    heard.wait_until(has_room_for(0))
    late = cluster.add_node()
    ready = heard.idle_worker()
    assert has_room_for(1)(heard.reports)
    heard.train(ready.worker, ENDLESS)
    heard.wait_for_training(ready.worker)
    late.machine.kill()
    heard.wait_for(lambda report: isinstance(report, Lost) and report.worker == ready.worker)
    heard.wait_until(has_room_for(0))
    heard.pool.demand(2)
    cluster.add_node()
    cluster.add_node()
    heard.wait_until(lambda reports: len([r for r in reports if isinstance(r, Ready)]) == 3)
    heard.wait_until(has_room_for(2))
