"""Placement of workers: on cores and memory of living nodes, as many as there is work for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Node:
    """A living node of the cluster: the name that Ray gave it, and how many workers fit on it."""

    name: str
    room: int


def room(resources: Mapping[str, float], worker_bytes: int) -> int:
    """How many workers a node has room for, by its cores and its memory, as Ray counts them.

    With 0 bytes a worker, by its cores alone.
    """
    cores = int(resources.get("CPU", 0))
    if not worker_bytes:
        return cores
    return min(cores, int(resources.get("memory", 0)) // worker_bytes)


@dataclass(frozen=True)
class Bounds:
    """How many workers there may be.

    least  are kept even if there is less work
    most   are never exceeded
    """

    least: int
    most: int

    def wanted(self, demand: int) -> int:
        """How many there should be if there is work for so many."""
        return min(max(demand, self.least), self.most)


def vacancies(nodes: Sequence[Node], slots: Mapping[str, int], wanted: int) -> list[Node]:
    """Return the node of each slot to make, given how many slots each node has.

    The fullest nodes come first, so that the others can be given back.
    """
    fullest_first = sorted(nodes, key=lambda node: -slots.get(node.name, 0))
    free = [node for node in fullest_first for _ in range(node.room - slots.get(node.name, 0))]
    return free[: max(0, wanted - sum(slots.values()))]
