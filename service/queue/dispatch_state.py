"""What the scheduler knows between two events: workers, what they train, the pool, the times."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from service.model.claim import Claim
from service.queue.messages import Version
from workers.messages.work import LEASE_SECONDS


@dataclass(frozen=True)
class DispatchTimes:
    """All in seconds.

    report   between two reports of a worker, where there are few
    longest_report  the same where there are many: several of them to a lease
    lease    a worker that is silent for so long has lost its runs
    grace    a worker that was told to drop a run has so long to do so before it is killed
    round    longest wait for reports; how late a cancelling or a new sweep is seen
    gather   after the first report of a round, so long for each worker others are waited for
    longest_gather  however many workers there are
    expiry   between two looks for expired leases
    demand   between two looks at how much work there is, where no worker is idle
    restart  before a pool that failed is started again, doubled each time up to `longest_restart`
    """

    report: float = 1.0
    longest_report: float = 5.0
    lease: float = LEASE_SECONDS
    grace: float = 5.0
    round: float = 0.1
    gather: float = 1e-4
    longest_gather: float = 0.1
    expiry: float = 1.0
    demand: float = 2.0
    restart: float = 1.0
    longest_restart: float = 30.0

    def gathering(self, workers: int) -> float:
        """Return how long reports of so many workers are gathered, to be written together.

        A round costs as much as several reports, and a worker trains on while its own waits.
        """
        return min(self.gather * workers, self.longest_gather)


@dataclass(frozen=True)
class Cohort:
    """What a worker is training.

    name      that of its first claim; what the worker calls it
    claim     on those of its runs that are still its own
    heard_at  when it last reported
    measures  the task whose random return it was asked to measure
    dropped   when it was told to drop each run
    """

    name: str
    claim: Claim
    heard_at: float
    measures: Version | None = None
    dropped: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class State:
    """All that is known between two events.

    idle             workers without work, in the order they became so
    cohorts          what each of the others trains
    random_returns   environments whose random return the store knew at the last look
    pool_is_up       the pool was started and has not been lost
    problem          why no run can start now, a sentence; empty while they can
    lost_since       time of day at which the pool was lost; empty while it is there
    restart_at       when a lost pool is started again
    restart_wait     how long after the next loss
    ticked_at        the last tick; None before the first
    expiry_at        when expired leases are looked for
    capacity         how many workers the cluster has room for
    demand           the number of workers that the pool was told to have; None: not told yet
    demand_at        when that is looked at again
    """

    idle: tuple[str, ...] = ()
    cohorts: Mapping[str, Cohort] = field(default_factory=dict)
    random_returns: frozenset[Version] = frozenset()
    pool_is_up: bool = False
    problem: str = "the cluster is starting"
    lost_since: str = ""
    restart_at: float = -math.inf
    restart_wait: float = 0.0
    ticked_at: float | None = None
    expiry_at: float = -math.inf
    capacity: int = 0
    demand: int | None = None
    demand_at: float = -math.inf

    @property
    def free_cores(self) -> int:
        """Cores of idle workers, and cores on which the pool can start more workers."""
        return max(len(self.idle), self.capacity - len(self.cohorts))

    def trains(self, worker: str, cohort: str) -> bool:
        """Whether that is what the worker is training."""
        return worker in self.cohorts and self.cohorts[worker].name == cohort

    def training(self, worker: str, cohort: Cohort) -> Self:
        """Return the state with the worker training that."""
        idle = tuple(name for name in self.idle if name != worker)
        return replace(self, idle=idle, cohorts={**self.cohorts, worker: cohort})

    def without(self, worker: str) -> Self:
        """Return the state without the worker."""
        idle = tuple(name for name in self.idle if name != worker)
        cohorts = {name: cohort for name, cohort in self.cohorts.items() if name != worker}
        return replace(self, idle=idle, cohorts=cohorts)

    def freeing(self, worker: str) -> Self:
        """Return the state with the worker idle, behind the others."""
        state = self.without(worker)
        return replace(state, idle=(*state.idle, worker))

    def up(self) -> Self:
        """Return the state with a pool that has reported."""
        return replace(self, problem="", lost_since="", restart_wait=0.0)
