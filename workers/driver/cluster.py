"""The Ray cluster that workers are on, joined or made for them, and the process that drives it.

With `workers/driver/actor.py` the only file that knows Ray.
"""

import itertools
import logging
import os
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import ray
from ray.autoscaler.sdk import request_resources

from workers.driver.actor import ActorSlot
from workers.driver.actor_pool import ActorPool
from workers.driver.outbox import Outbox
from workers.driver.placement import Node, room
from workers.driver.reception import Reception
from workers.driver.settings import DriverSettings
from workers.driver.terms import Terms

OBJECT_STORE_BYTES = 80 * 2**20  # nearly Ray's least; progress is small and never stored
JOIN_SECONDS = 20.0
WITHDRAWAL_SECONDS = 1.0
"""How long withdrawing the request to the autoscaler may delay the end."""
START_SECONDS = 90.0  # on a busy machine; alone it takes 5 to 8


class RayCluster:
    """The cluster that this process is connected to."""

    def __init__(self, terms: Terms, logs: Path, send: Callable[[str], None]) -> None:
        """Workers report to `send`, and log in a folder."""
        self._terms = terms
        self._logs = logs
        self._own_node = ray.get_runtime_context().get_node_id()
        self._names = itertools.count(1)
        self._send = send

    def nodes(self) -> list[Node]:
        """Return the living ones with room for a worker.

        Ends the process if its own node is dead: then no worker can start any more.
        """
        found: list[dict[str, Any]] = ray.nodes()  # type: ignore[no-untyped-call]
        living = [node for node in found if node["Alive"]]
        if self._own_node not in {node["NodeID"] for node in living}:
            _give_up("Ray's node on this machine is dead: its raylet was killed, or did not answer")
        nodes = [Node(n["NodeID"], room(n["Resources"], self._terms.worker_bytes)) for n in living]
        return [node for node in nodes if node.room > 0]

    def make_slot(self, node: Node) -> ActorSlot:
        """Begin to start a worker there."""
        return ActorSlot(node, self._names, self._terms, self._logs, self._send)

    def request(self, workers: int) -> None:
        """Ask the autoscaler of a joined cluster for room for so many; 0: any.

        Ray keeps to the last request, even after the requesting process has ended. Actors that wait
        for a place would request cores, too. But each requests one beside those in use, is pinned
        to a node here, and repeats its request after others have done the work.
        """
        memory = self._terms.worker_bytes
        if self._terms.address:
            worker = {"CPU": 1} | ({"memory": memory} if memory else {})
            request_resources(bundles=workers * [worker])


def drive(listener: socket.socket, settings: DriverSettings) -> None:
    """Let a service name the cluster, join or make it, and serve connections to the listener."""
    outbox = Outbox(settings.spool)
    reception = Reception(listener, outbox, waits_long=settings.stands_alone)
    terms = reception.first_terms()
    if terms is None:
        return
    _connect(terms, settings.scratch)
    try:
        pool = ActorPool(outbox, RayCluster(terms, settings.logs, outbox.put), terms.bounds)
        follower = threading.Thread(target=pool.follow, name="nodes", daemon=True)
        follower.start()
        pool.serve(reception.visits())
        follower.join(WITHDRAWAL_SECONDS)
    finally:
        ray.shutdown()


def _connect(terms: Terms, scratch: str) -> None:
    if address := terms.address:
        with _deadline(JOIN_SECONDS, f"Ray at {address} did not answer in {JOIN_SECONDS:.0f} s"):
            ray.init(address=address, log_to_driver=False, logging_level=logging.WARNING)
    else:
        with _deadline(START_SECONDS, f"Ray did not start in {START_SECONDS:.0f} s"):
            ray.init(
                address="local",
                num_cpus=terms.most,
                object_store_memory=OBJECT_STORE_BYTES,
                include_dashboard=False,
                log_to_driver=False,
                logging_level=logging.WARNING,
                _temp_dir=scratch,
            )


def _give_up(complaint: str) -> None:
    """End the process with the complaint as its last line."""
    print(complaint, file=sys.stderr, flush=True)  # noqa: T201
    os._exit(1)


@contextmanager
def _deadline(seconds: float, complaint: str) -> Iterator[None]:
    """End the process, with the complaint as its last line, if the block takes longer.

    `ray.init` waits for ever for a cluster that does not answer, and cannot be interrupted.
    """
    timer = threading.Timer(seconds, _give_up, [complaint])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
