"""A cluster without Ray: nodes as a test says, slots that note what they are told."""

import threading
from collections.abc import Collection
from dataclasses import dataclass, field

from workers.driver.placement import Node
from workers.messages.work import Work


@dataclass
class FakeSlot:
    """A slot whose worker is up at once."""

    node: str
    worker: str
    works: list[Work] = field(default_factory=list)
    dropped: list[Collection[int]] = field(default_factory=list)
    idle_seconds: float = 0.0
    is_retired: bool = False
    killed: threading.Event = field(default_factory=threading.Event)
    is_closed: bool = False

    def train(self, work: Work) -> None:
        self.works.append(work)

    def drop(self, seeds: Collection[int]) -> None:
        self.dropped.append(seeds)

    def kill(self) -> None:
        self.killed.set()

    def close(self) -> None:
        self.is_closed = True

    def retire(self) -> None:
        self.is_closed = self.is_retired = True


class FakeCluster:
    """Nodes by name, with their cores."""

    def __init__(self, **cores: int) -> None:
        self.cores = cores
        self.slots: list[FakeSlot] = []
        self.requests: list[int] = []
        self.requested = threading.Event()

    def nodes(self) -> list[Node]:
        return [Node(name, cores) for name, cores in self.cores.items()]

    def make_slot(self, node: Node) -> FakeSlot:
        slot = FakeSlot(node.name, f"worker-{len(self.slots) + 1}")
        self.slots.append(slot)
        return slot

    def request(self, workers: int) -> None:
        self.requests.append(workers)
        self.requested.set()

    def open_on(self, node: str) -> list[FakeSlot]:
        """The slots of a node that were not closed."""
        return [slot for slot in self.slots if slot.node == node and not slot.is_closed]
