"""The store: what the rest of the service asks of the database.

Promises. Safe from any thread. Every method is one transaction: all of it happens or nothing, and
what a method returned has survived a power cut. A crash leaves the last committed state. Final
states never change, and a write under a claim that was given up changes nothing. Every change
appends its event in the same transaction. Floats come back as they went in (see
`column_types.Exact`), NaN and infinities too.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Self

from sqlalchemy import Engine, text

from algorithms.measurement import Measurement
from service.claim import Claim
from service.event import Event
from service.metrics import MEASUREMENTS
from service.run import Attempt, Run, RunStatus
from service.run_curve import RunCurve
from service.store import (
    claims,
    endings,
    events,
    measurements,
    random_returns,
    records,
    runs,
    sweeps,
)
from service.store.connection import connect
from service.store.migration import upgrade
from service.store.retry import RetryPolicy
from service.store.run_order import AS_MADE, RunOrder
from service.store.writer import Writer
from service.sweep import Sweep
from workers.progress import Progress
from workers.random_return import RandomReturn
from workers.run_spec import COHORT_LIMIT, RunSpec


class Store:
    """One open database. `Store.open` makes one; `close` commits what is queued and ends it."""

    def __init__(self, writer_engine: Engine, reader_engine: Engine, retry: RetryPolicy) -> None:
        """Start the writer's thread on tables that are this version's."""
        self._writer_engine = writer_engine
        self._readers = reader_engine
        self._retry = retry
        self._writer = Writer(writer_engine)

    @classmethod
    def open(cls, url: str, retry: RetryPolicy | None = None) -> Self:
        """Open the database, after bringing its tables to this version's."""
        writer = connect(url, "writer")
        upgrade(writer)
        return cls(writer, connect(url, "reader"), retry or RetryPolicy())

    def close(self) -> None:
        """Commit what is queued and let go of the database."""
        self._writer.close()
        self._readers.dispose()
        self._writer_engine.dispose()

    def check(self) -> None:
        """Read something; raises what the database raises when it cannot."""
        with self._readers.connect() as connection:
            connection.execute(text("SELECT 1 FROM runs LIMIT 1")).all()

    # ---- sweeps and runs

    def create_sweep(
        self,
        name: str,
        priority: int,
        request: Mapping[str, Any],
        specs: Sequence[RunSpec],
        *,
        environment_versions: Mapping[str, int],
    ) -> Sweep:
        """Write a sweep and its runs; the versions are those of the specs' environments."""
        if not specs:
            raise ValueError("a sweep has at least one run, got none")
        return self._writer.write(
            lambda c: sweeps.create(
                c,
                name=name,
                priority=priority,
                request=request,
                specs=specs,
                environment_versions=environment_versions,
            )
        )

    def find_sweep(self, sweep_id: str) -> Sweep | None:
        """Return one sweep, or None."""
        with self._readers.connect() as connection:
            return sweeps.find(connection, sweep_id)

    def list_sweeps(self, after: str | None = None, limit: int = 50) -> list[Sweep]:
        """Return sweeps, newest first, from the one that follows the sweep `after`."""
        with self._readers.connect() as connection:
            return sweeps.page(connection, after, limit)

    def cancel_sweep(self, sweep_id: str) -> Sweep:
        """Cancel what has not ended. Raises NotFoundError, ImpossibleMoveError."""
        return self._writer.write(lambda c: sweeps.cancel(c, sweep_id))

    def find_run(self, run_id: str) -> Run | None:
        """Return one run, or None."""
        with self._readers.connect() as connection:
            return runs.find(connection, run_id)

    def list_runs(
        self,
        sweep_id: str,
        *,
        status: RunStatus | None = None,
        algorithm: str | None = None,
        environment: str | None = None,
        order: RunOrder = AS_MADE,
        after: str | None = None,
        limit: int = 100,
    ) -> list[Run]:
        """Return runs of a sweep in an order, from the one that follows the run `after`."""
        with self._readers.connect() as connection:
            return runs.page(
                connection,
                sweep_id,
                status=status,
                algorithm=algorithm,
                environment=environment,
                order=order,
                after=after,
                limit=limit,
            )

    def cancel_run(self, run_id: str) -> Run:
        """Cancel a run. Raises NotFoundError, ImpossibleMoveError."""
        return self._writer.write(lambda c: runs.cancel(c, run_id))

    def attempts(self, run_id: str) -> list[Attempt]:
        """Return every attempt of a run, the first one first."""
        with self._readers.connect() as connection:
            return runs.history(connection, run_id)

    # ---- the queue

    def claim_cohort(
        self, worker: str, lease_seconds: float, limit: int = COHORT_LIMIT
    ) -> Claim | None:
        """Claim up to `limit` queued runs of one cell, or None when nothing waits."""
        return self._writer.write(
            lambda c: claims.claim(c, worker, lease_seconds, min(limit, COHORT_LIMIT))
        )

    def waiting_runs(self) -> int:
        """Return how many runs could be claimed now."""
        with self._readers.connect() as connection:
            return claims.waiting(connection)

    def count_runs(self) -> dict[str, int]:
        """Return how many runs of all sweeps there are by status, every status named."""
        with self._readers.connect() as connection:
            return runs.count(connection)

    def count_attempts(self) -> dict[str, int]:
        """Return how many attempts of all runs there were by outcome."""
        with self._readers.connect() as connection:
            return runs.count_attempts(connection)

    def cancelling_runs(self) -> set[str]:
        """Return the running runs whose workers are to stop them."""
        with self._readers.connect() as connection:
            return runs.cancelling(connection)

    def record(self, claim: Claim, progress: Progress) -> set[str]:
        """Write what a worker said, renew the lease, end runs that ended by themselves.

        Returns the runs of the claim that go on; the worker is to stop training the others.
        """
        held = self._writer.write(lambda c: records.record(c, claim, progress))
        MEASUREMENTS.inc(len(progress.measurements))
        return held

    def fail(self, claim: Claim, error: str, log_tail: str = "") -> None:
        """End what is left of the claim as failed: an error in code, which would happen again."""
        self._writer.write(lambda c: endings.fail(c, claim, error, log_tail))

    def release(self, claim: Claim, reason: str) -> None:
        """Queue what is left of the claim again at once; nothing was wrong with it.

        Here and in `lose`: runs whose cancelling was asked for are cancelled instead.
        """
        self._writer.write(lambda c: endings.release(c, claim, reason))

    def lose(self, claim: Claim, reason: str, log_tail: str = "") -> None:
        """Queue what is left of the claim again after a wait, or fail it after too many losses."""
        self._writer.write(lambda c: endings.lose(c, claim, reason, log_tail, self._retry))

    def lose_expired(self) -> int:
        """Do as `lose` with every run whose lease has ended; return how many there were."""
        with self._readers.connect() as connection:  # usually none: then nothing is written
            if not claims.has_expired(connection):
                return 0
        return self._writer.write(lambda c: endings.lose_expired(c, self._retry))

    # ---- what was measured

    def measurements(self, run_id: str) -> list[Measurement]:
        """Return every measurement of a run, in order of timestep."""
        with self._readers.connect() as connection:
            return measurements.of_run(connection, run_id)

    def curve_points(self, sweep_id: str, metric: str, x: str = "timesteps") -> list[RunCurve]:
        """Return one metric of every run of a sweep.

        metric is "return_mean", "return_history" or a diagnostic's name; x is "timesteps",
        "updates", "jacobians" or "seconds" (ValueError otherwise).
        """
        with self._readers.connect() as connection:
            return measurements.curves(connection, sweep_id, metric, x)

    def return_outlines(self, run_ids: Sequence[str], points: int) -> dict[str, list[float]]:
        """Return about so many return_mean of each run, evenly spaced and the latest one last."""
        with self._readers.connect() as connection:
            return measurements.outlines(connection, run_ids, points)

    def diagnostic_names(self, sweep_id: str) -> list[str]:
        """Return the names of all diagnostics that runs of the sweep have measured."""
        with self._readers.connect() as connection:
            return measurements.diagnostic_names(connection, sweep_id)

    def record_random_return(self, measured: RandomReturn) -> None:
        """Write the random return of one environment version."""
        self._writer.write(lambda c: random_returns.put(c, measured))

    def random_returns(self) -> dict[tuple[str, int], RandomReturn]:
        """Return every random return by (environment, version)."""
        with self._readers.connect() as connection:
            return random_returns.of_all(connection)

    # ---- events

    def events_after(
        self, event_id: int, sweep_id: str | None = None, limit: int = 1000
    ) -> list[Event]:
        """Return the oldest events after one, of one sweep or of all."""
        with self._readers.connect() as connection:
            return events.after(connection, event_id, sweep_id, limit)

    def last_event_id(self) -> int:
        """Return the newest event's id, 0 when there is none."""
        with self._readers.connect() as connection:
            return events.last_id(connection)

    def sweep_version(self, sweep_id: str) -> str | None:
        """Return a text that changes with whatever is shown of a sweep; None: no such sweep."""
        with self._readers.connect() as connection:
            last = events.last_id_of(connection, sweep_id)
            zeros = random_returns.last_measured_at(connection)
        return None if last is None else f"{last}-{zeros!r}"
