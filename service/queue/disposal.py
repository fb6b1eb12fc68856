"""Removal of deleted sweeps, and of policies and events that are older than they are kept.

Files are removed before the rows that refer to them, so none is forgotten when the service dies in
between. Freed space is logged, and counted for Prometheus.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import structlog

from service.metrics import FREED_BYTES, FREED_ROWS
from service.queue.rounds import Rounds
from service.store.store import Store
from workers.checkpoints.checkpoint_folder import remove_all, remove_policies
from workers.checkpoints.place import Place

log = structlog.get_logger(__name__)

RUNS_AT_ONCE = 32
POLICIES_AT_ONCE = 256
RETENTION_SECONDS = 600.0
DAY = 86_400.0


@dataclass(frozen=True)
class Retention:
    """The number of days to keep policies and events; None: for ever."""

    policy_days: float | None = None
    event_days: float | None = None


class Disposal(Rounds):
    """Removes deleted sweeps every few seconds, and what is too old every ten minutes."""

    def __init__(
        self,
        store: Store,
        place: Place,
        retention: Retention,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Begin nothing yet; the clock is for tests."""
        super().__init__("throwing away")
        self._store = store
        self._place = place
        self._retention = retention
        self._clock = clock
        self._due_at = clock()

    def work(self) -> bool:
        """Remove some of it."""
        if self._purge_deleted():
            return True
        if self._clock() < self._due_at:
            return False
        if self._purge_policies() or self._purge_events():
            return True
        self._due_at = self._clock() + RETENTION_SECONDS
        return False

    def _purge_deleted(self) -> bool:
        gone = self._store.deleted_runs(RUNS_AT_ONCE)
        for run_id in gone:
            remove_all(self._place, run_id)
        if not gone:
            return self._store.purge_sweep()
        purged = self._store.purge_runs(gone)
        FREED_ROWS.labels("runs").inc(purged.runs)
        FREED_ROWS.labels("measurements").inc(purged.measurements)
        return True

    def _purge_policies(self) -> bool:
        if self._retention.policy_days is None:
            return False
        kept_seconds = self._retention.policy_days * DAY
        old = self._store.old_policies(kept_seconds, POLICIES_AT_ONCE)
        if not old:
            return False
        freed = sum(remove_policies(self._place, run_id) for run_id in old)
        self._store.forget_policies(old)
        FREED_BYTES.labels("policies").inc(freed)
        log.info("old policies were removed", runs=len(old), bytes=freed)
        return True

    def _purge_events(self) -> bool:
        if self._retention.event_days is None:
            return False
        freed = self._store.purge_events(self._retention.event_days * DAY)
        if freed:
            FREED_ROWS.labels("events").inc(freed)
            log.info("old events were removed", events=freed)
        return freed > 0
