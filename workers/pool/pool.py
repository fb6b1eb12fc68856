"""A pool of workers, as seen by the one who gives them work."""

from collections.abc import Collection
from typing import Protocol

from workers.messages.report import Report
from workers.messages.work import Work


class PoolUnavailableError(RuntimeError):
    """The pool cannot be had, or is no more; its text is a sentence that says why."""


class Pool(Protocol):
    """Workers, each with one piece of work at a time.

    Every call returns at once; what comes of it arrives as reports. A command for a worker that is
    no more does nothing: its Lost is on the way.
    """

    def start(self) -> None:
        """Begin to bring workers up, for which there is Capacity; each says Ready.

        Raises PoolUnavailableError.
        """

    def train(self, worker: str, work: Work) -> None:
        """Train a cohort: Busy, News as often as is asked for, then Ended, Failed or Lost.

        Where asked, the random return of its task is measured first, and is in the News.
        """

    def drop(self, worker: str, seeds: Collection[int]) -> None:
        """Ask a worker to train these seeds no further; it names them in a progress to come."""

    def kill(self, worker: str) -> None:
        """End a worker's process, whatever it does; Lost."""

    def demand(self, workers: int) -> None:
        """Say that there is work for so many workers: they come, as far as the cluster can.

        Those that are not needed end after a while, each with Retired, or stay.
        """

    def reports(self, timeout_seconds: float, gather_seconds: float = 0.0) -> list[Report]:
        """Wait that long for a report, gather others for a while, and return them in order.

        Raises PoolUnavailableError when the pool is no more.
        """

    def acknowledge(self, count: int) -> None:
        """So many more of the reports given out are recorded, in their order.

        Those that are not are given out again after the service was killed.
        """

    def close(self) -> None:
        """End all workers and wait until nothing of the pool is left."""
