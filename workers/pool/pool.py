"""A pool of workers, as its user sees it."""

from collections.abc import Collection
from typing import Protocol

from workers.messages.report import Report
from workers.messages.work import Work


class PoolUnavailableError(RuntimeError):
    """The pool is unavailable, or has ended; its text is a sentence that says why."""


class Pool(Protocol):
    """Workers, each with one piece of work at a time.

    Every call returns at once; its results arrive as reports. A command for a worker that has ended
    does nothing: its Lost is on the way.
    """

    def start(self) -> None:
        """Begin to start workers, for which there is Capacity; each reports Ready.

        Raises PoolUnavailableError.
        """

    def train(self, worker: str, work: Work) -> None:
        """Train a cohort: Busy, News as often as is asked for, then Ended, Failed or Lost.

        On request, the random return of its task is measured first, and is in the News.
        """

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        """Ask a worker to stop training these seeds; it names them in a later progress."""

    def kill(self, worker: str) -> None:
        """End a worker's process, whatever it does; Lost."""

    def demand(self, workers: int) -> None:
        """Tell for how many workers there is work: they start, as far as the cluster has room.

        Workers that are not needed end after a while, each with Retired, or stay.
        """

    def reports(self, timeout_seconds: float, gather_seconds: float = 0.0) -> list[Report]:
        """Wait that long for a report, gather others for a while, and return them in order.

        Raises PoolUnavailableError when the pool has ended.
        """

    def acknowledge(self, count: int) -> None:
        """Mark the next `count` returned reports, in their order, as recorded.

        Other reports are returned again after the service was killed.
        """

    def close(self) -> None:
        """End all workers and wait until nothing of the pool is left."""
