"""The pool's slots: they follow the nodes, and what a service says reaches the right one."""

import json
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.workers.fake_cluster import FakeCluster
from workers.driver.actor_pool import IDLE_SECONDS, ActorPool
from workers.driver.outbox import Outbox
from workers.driver.reception import Reception, Visit
from workers.driver.terms import Terms
from workers.messages.assignment import Assignment
from workers.messages.report import Capacity, Report, from_line
from workers.messages.run_spec import RunSpec
from workers.messages.work import Work

TERMS = Terms("head:6379", least=3, most=5, worker_bytes=0, checkpoints="s3://bucket")
WORK = Work("a-0/1", (Assignment("a-0", 1, RunSpec("ddpg", "Pendulum", 0), 1),))


class Service:
    """The other end of a pool's socket."""

    def __init__(self, path: Path) -> None:
        self._channel = socket.socket(socket.AF_UNIX)
        self._channel.settimeout(10.0)
        self._channel.connect(str(path))
        self._lines = self._channel.makefile("rb")
        self._channel.sendall(TERMS.to_line())
        self._lines.readline()  # the greeting

    def say(self, **command: Any) -> None:
        self._channel.sendall(json.dumps(command).encode() + b"\n")

    def hear(self, count: int) -> list[Report]:
        return [from_line(self._lines.readline()) for _ in range(count)]

    def close_pool(self) -> None:
        """Close the pool and wait for its end."""
        self.say(do="close")
        self._channel.shutdown(socket.SHUT_WR)
        self._lines.read()

    def close(self) -> None:
        self._lines.close()
        self._channel.close()


@pytest.fixture
def cluster() -> FakeCluster:
    return FakeCluster(one=1, two=2)


@pytest.fixture
def outbox(tmp_path: Path) -> Outbox:
    return Outbox(tmp_path / "spool.jsonl")


@pytest.fixture
def pool(cluster: FakeCluster, outbox: Outbox) -> ActorPool:
    return ActorPool(outbox, cluster, TERMS.bounds)


@pytest.fixture
def serving(pool: ActorPool, outbox: Outbox, tmp_path: Path) -> Iterator[threading.Thread]:
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "sock"))
        listener.listen(1)
        reception = Reception(listener, outbox, waits_long=True)
        thread = threading.Thread(target=lambda: pool.serve(served(reception)))
        thread.start()
        yield thread
        thread.join()


def served(reception: Reception) -> Iterator[Visit]:
    reception.first_terms()
    yield from reception.visits()


@pytest.fixture
def service(serving: threading.Thread, tmp_path: Path) -> Iterator[Service]:
    service = Service(tmp_path / "sock")
    yield service
    if serving.is_alive():
        service.close_pool()
    service.close()


def test_the_least_number_of_slots_is_always_there(pool: ActorPool, cluster: FakeCluster) -> None:
    for _ in range(2):
        pool.look()
        assert [slot.node for slot in cluster.slots] == ["one", "two", "two"]


def test_a_node_that_joins_later_has_slots_too(pool: ActorPool, cluster: FakeCluster) -> None:
    cluster.cores = {}
    pool.look()
    assert cluster.slots == []
    cluster.cores = {"late": 2}
    pool.look()
    assert [slot.node for slot in cluster.slots] == ["late", "late"]


def test_the_slots_of_a_node_go_with_it_and_the_others_stay(
    pool: ActorPool, cluster: FakeCluster
) -> None:
    pool.look()
    cluster.cores = {"one": 1}
    pool.look()
    assert cluster.open_on("two") == []
    assert all(slot.killed.is_set() for slot in cluster.slots if slot.node == "two")
    assert [slot.killed.is_set() for slot in cluster.open_on("one")] == [False]
    cluster.cores = {"one": 1, "two again": 2}
    pool.look()
    assert len(cluster.open_on("two again")) == 2


def test_the_service_is_told_what_there_is_room_for_when_it_changes(
    pool: ActorPool, cluster: FakeCluster, service: Service
) -> None:
    for cores in (0, 1, 1, 4, 9):
        cluster.cores = {"one": cores}
        pool.look()
    cluster.cores = {}
    pool.look()
    assert service.hear(5) == [
        Capacity(0, slots=0),
        Capacity(1, slots=1),
        Capacity(4, slots=3),
        Capacity(5, slots=3),
        Capacity(0, slots=0),
    ]


def test_slots_come_as_there_is_work_for_them_and_go_when_long_idle(
    pool: ActorPool, cluster: FakeCluster
) -> None:
    cluster.cores = {"one": 2, "two": 6}
    pool.demand(4)
    pool.look()
    assert [slot.node for slot in cluster.slots] == ["one", "one", "two", "two"]
    pool.demand(1000)
    pool.look()
    assert len(cluster.slots) == 5
    pool.demand(0)
    pool.look()
    for slot in cluster.slots[1:]:
        slot.idle_seconds = IDLE_SECONDS + 1
    pool.look()  # the node that is idle as a whole is emptied first; three are always kept
    assert [slot.is_retired for slot in cluster.slots] == [False, False, True, True, False]
    pool.look()
    assert sum(slot.is_retired for slot in cluster.slots) == 2


def test_what_is_missing_is_asked_of_the_autoscaler_until_it_is_there(
    pool: ActorPool, cluster: FakeCluster
) -> None:
    pool.look()
    pool.demand(5)
    pool.look()
    pool.look()
    cluster.cores["three"] = 2
    pool.look()
    assert cluster.requests == [0, 5, 0]


def test_a_demand_is_heeded_at_once_and_withdrawn_at_the_end(
    pool: ActorPool, cluster: FakeCluster, serving: threading.Thread, service: Service
) -> None:
    follower = threading.Thread(target=pool.follow, daemon=True)
    follower.start()
    service.say(do="demand", workers=4)
    deadline = time.monotonic() + 10.0
    while cluster.requests != [0, 4]:
        assert time.monotonic() < deadline
        cluster.requested.wait(1.0)
    service.close_pool()
    follower.join()
    serving.join()
    assert cluster.requests == [0, 4, 0]


def test_commands_reach_the_slot_of_the_worker_they_name(
    cluster: FakeCluster, pool: ActorPool, service: Service
) -> None:
    pool.look()
    service.say(do="train", worker="worker-2", work=WORK.to_json())
    service.say(do="drop", worker="worker-2", seeds=[3])
    service.say(do="train", worker="worker-of-old", work=WORK.to_json())
    service.say(do="kill", worker="worker-3")
    assert cluster.slots[2].killed.wait(10.0)
    assert [slot.works for slot in cluster.slots] == [[], [WORK], []]
    assert [slot.dropped for slot in cluster.slots] == [[], [[3]], []]
    assert [slot.killed.is_set() for slot in cluster.slots] == [False, False, True]
