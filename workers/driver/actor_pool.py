"""All slots of a cluster, which follow its nodes and the work; serves one service at a time.

A slot is a core of a node, and ends with it; a node that comes back is a new one to Ray, and here.
There are as many slots as there is work for, as the service says, within bounds. The cluster's
autoscaler is asked for missing slots, and slots that have long been idle are retired, so that their
node can be given back.
"""

import json
import sys
import threading
import traceback
from collections import Counter
from collections.abc import Collection, Iterable
from contextlib import suppress
from typing import Any, Protocol

from workers.driver.outbox import Outbox
from workers.driver.placement import Bounds, Node, vacancies
from workers.driver.reception import Visit
from workers.messages.report import Capacity, to_line
from workers.messages.work import Work

LOOK_SECONDS = 2.0
"""Time between two looks at the cluster's nodes."""
IDLE_SECONDS = 300.0
"""How long an idle worker is kept warm; starting one takes a few seconds."""


class Slot(Protocol):
    """Room for one worker, which is replaced when it is lost."""

    @property
    def node(self) -> str:
        """The node of the slot."""

    @property
    def worker(self) -> str:
        """The name of its present worker."""

    @property
    def idle_seconds(self) -> float:
        """How long it has been idle, the start of its worker included."""

    def train(self, work: Work) -> None:
        """Give the worker a cohort."""

    def drop(self, seeds: Collection[int]) -> None:
        """Stop the training of these seeds."""

    def kill(self) -> None:
        """End the worker's process."""

    def close(self) -> None:
        """Make no new worker after this one."""

    def retire(self) -> None:
        """End the worker, which is idle; Retired."""


class Cluster(Protocol):
    """What the pool asks of Ray."""

    def nodes(self) -> list[Node]:
        """The living nodes."""

    def make_slot(self, node: Node) -> Slot:
        """Begin to start a worker there; its reports come by themselves."""

    def request(self, workers: int) -> None:
        """Ask the autoscaler, if there is one, for a cluster with room for so many; 0: any."""


class ActorPool:
    """Slots, until a service closes the pool or none connects. `follow` runs on its own thread."""

    def __init__(self, outbox: Outbox, cluster: Cluster, bounds: Bounds) -> None:
        """Make no slot yet."""
        self._outbox = outbox
        self._cluster = cluster
        self._bounds = bounds
        self._demand = 0  # workers that there is work for
        self._requested: int | None = None  # of the autoscaler; whoever was here before us, too
        self._slots: list[Slot] = []
        self._lock = threading.Lock()  # of the slots
        self._capacity: Capacity | None = None
        self._closed = threading.Event()
        self._awake = threading.Event()

    def serve(self, visits: Iterable[Visit]) -> None:
        """Serve one service after the other, until one closes the pool or none connects."""
        for visit in visits:
            with suppress(OSError, ValueError):  # cut off, perhaps within a line
                for line in visit.lines:
                    self._obey(json.loads(line))
            if self._closed.is_set():
                break
        self._closed.set()
        self._awake.set()
        with self._lock:
            for slot in self._slots:
                slot.close()

    def follow(self) -> None:
        """Add and remove slots with nodes and demand, until the pool is closed.

        The request to the autoscaler is withdrawn then.
        """
        while not self._closed.is_set():
            try:
                self.look()
            except Exception:  # Ray was asked in a bad moment; it is asked again
                traceback.print_exc(file=sys.stderr)
            self._awake.wait(LOOK_SECONDS)
            self._awake.clear()
        if self._requested:
            self._request(0)

    def demand(self, workers: int) -> None:
        """Set for how many workers there is work."""
        self._demand = workers
        self._awake.set()

    def look(self) -> None:
        """See which nodes live, and make, retire and close slots accordingly."""
        nodes = self._cluster.nodes()
        wanted = self._bounds.wanted(self._demand)
        with self._lock:
            lost = self._take_out_lost({node.name for node in nodes})
            self._retire_idle(wanted)
            for node in vacancies(nodes, Counter(slot.node for slot in self._slots), wanted):
                self._slots.append(self._cluster.make_slot(node))
            slots = len(self._slots)
        for slot in lost:  # a process there may not have noticed that its node counts as dead
            slot.close()
            slot.kill()
        self._tell(Capacity(min(sum(node.room for node in nodes), self._bounds.most), slots))
        self._request(wanted if wanted > slots else 0)

    def _take_out_lost(self, living: set[str]) -> list[Slot]:
        lost = [slot for slot in self._slots if slot.node not in living]
        self._slots = [slot for slot in self._slots if slot.node in living]
        return lost

    def _retire_idle(self, wanted: int) -> None:
        """Retire idle slots that are not needed; first those that empty a node."""
        idle = [slot for slot in self._slots if slot.idle_seconds > IDLE_SECONDS]
        others = Counter(slot.node for slot in self._slots if slot not in idle)
        idle.sort(key=lambda slot: (others[slot.node], slot.node))
        for slot in idle[: max(0, len(self._slots) - wanted)]:
            self._slots.remove(slot)
            slot.retire()

    def _tell(self, capacity: Capacity) -> None:
        if capacity != self._capacity:
            self._capacity = capacity
            self._outbox.put(to_line(capacity))

    def _request(self, workers: int) -> None:
        if workers != self._requested:
            self._cluster.request(workers)
            self._requested = workers

    def _obey(self, command: dict[str, Any]) -> None:
        if command["do"] == "close":
            self._closed.set()
            self._awake.set()
            return
        if command["do"] == "demand":
            self.demand(command["workers"])
            return
        if command["do"] == "acknowledge":
            self._outbox.acknowledge(command["count"])
            return
        with self._lock:
            slot = next((slot for slot in self._slots if slot.worker == command["worker"]), None)
            if slot is None:
                return
            if command["do"] == "train":
                slot.train(Work.from_json(command["work"]))
            elif command["do"] == "drop":
                slot.drop(command["seeds"])
            elif command["do"] == "kill":
                slot.kill()
