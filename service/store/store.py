"""The store: what the rest of the service asks of the database.

Promises. Safe from any thread. Every method is one transaction: all of it happens or nothing, and
what a method returned has survived a power cut. A crash leaves the last committed state. Final
states never change, but that users may retry what failed, and a write under a claim that was given
up changes nothing. Every change appends its event in the same transaction. Floats come back as they
went in (see `column_types.Exact`), NaN and infinities too. A database that restarts is waited for
(`outage`): what was under way then happens once, and late.

One store writes to a database: a second is refused (on SQLite by the lock on the data directory).
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Self

from sqlalchemy import Connection, Engine, text

from algorithms.measurement import Measurement
from service.analysis.cost import PastCost
from service.metrics import MEASUREMENTS
from service.model.claim import CellLimit, Claim, no_limit
from service.model.event import Event
from service.model.move import Move
from service.model.run import Attempt, Run, RunStatus
from service.model.run_curve import RunCurve
from service.model.sweep import Sweep
from service.store import records
from service.store.claiming import checkpoints, claims, endings, run_moves, sweep_moves
from service.store.claiming.retry import RetryPolicy
from service.store.connection import connect
from service.store.reader import Reader
from service.store.reading import costs, events, measurements, random_returns, runs, sweeps
from service.store.reading.run_order import AS_MADE, RunOrder
from service.store.upkeep.migration import upgrade
from service.store.writer import Writer
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import COHORT_LIMIT, RunSpec


class Store:
    """One open database. `Store.open` makes one; `close` commits what is queued and ends it."""

    def __init__(self, writer_engine: Engine, reader_engine: Engine, retry: RetryPolicy) -> None:
        """Start the writer's thread on tables that are this version's."""
        self._writer_engine = writer_engine
        self._reader = Reader(reader_engine)
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
        self._reader.close()
        self._writer_engine.dispose()

    def check(self) -> None:
        """Read something, and where the last write failed, write; raises what the database raises.

        Without that, a disk that was full would be so until somebody had to write something.
        """
        self._reader.read(lambda c: c.execute(text("SELECT 1 FROM runs LIMIT 1")).all())
        if self._writer.is_failing:
            self._writer.write(lambda _: None)  # the commit's name is written

    # ---- sweeps and runs

    def create_sweep(
        self,
        name: str,
        priority: int,
        request: Mapping[str, Any],
        specs: Sequence[RunSpec],
        *,
        environment_versions: Mapping[str, int],
        submission_key: str | None = None,
    ) -> Sweep:
        """Write a sweep and its runs; the versions are those of the specs' environments.

        Under a submission key that was used before, return the sweep that was made then. Raises
        SubmissionKeyReusedError where that one was another.
        """
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
                submission_key=submission_key,
            )
        )

    def find_sweep(self, sweep_id: str) -> Sweep | None:
        """Return one sweep, or None."""
        return self._reader.read(lambda c: sweeps.find(c, sweep_id))

    def sweep_request(self, sweep_id: str) -> Mapping[str, Any]:
        """Return what was posted. Raises NotFoundError."""
        return self._reader.read(lambda c: sweeps.request(c, sweep_id))

    def list_sweeps(self, after: str | None = None, limit: int = 50) -> list[Sweep]:
        """Return sweeps, newest first, from the one that follows the sweep `after`."""
        return self._reader.read(lambda c: sweeps.page(c, after, limit))

    def move_sweep(self, sweep_id: str, asked: Move) -> Sweep:
        """Cancel, pause, resume or retry a sweep. Raises NotFoundError, ImpossibleMoveError."""
        return self._writer.write(lambda c: sweep_moves.move_sweep(c, sweep_id, asked))

    def find_run(self, run_id: str) -> Run | None:
        """Return one run, or None."""
        return self._reader.read(lambda c: runs.find(c, run_id))

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
        return self._reader.read(
            lambda c: runs.page(
                c,
                sweep_id,
                status=status,
                algorithm=algorithm,
                environment=environment,
                order=order,
                after=after,
                limit=limit,
            )
        )

    def move_run(self, run_id: str, asked: Move) -> Run:
        """Cancel, pause, resume or retry one run. Raises NotFoundError, ImpossibleMoveError."""
        return self._writer.write(lambda c: run_moves.move_run(c, run_id, asked))

    def attempts(self, run_id: str) -> list[Attempt]:
        """Return every attempt of a run, the first one first."""
        return self._reader.read(lambda c: runs.history(c, run_id))

    # ---- the queue

    def claim_cohort(
        self,
        worker: str,
        lease_seconds: float,
        limit: int = COHORT_LIMIT,
        limit_of: CellLimit = no_limit,
    ) -> Claim | None:
        """Claim up to `limit` queued runs of one cell, or None when nothing waits.

        And no more than the cell's own limit.
        """
        [claim] = self.claim_all([(worker, limit)], lease_seconds, limit_of)
        return claim

    def claim_all(
        self,
        asked: Sequence[tuple[str, int]],
        lease_seconds: float,
        limit_of: CellLimit = no_limit,
    ) -> list[Claim | None]:
        """Do as `claim_cohort` for several workers (worker, limit) in turn, at once."""

        def at_most(limit: int) -> CellLimit:
            return lambda cell: min(limit, limit_of(cell), COHORT_LIMIT)

        limits = [(worker, at_most(limit)) for worker, limit in asked]
        return self._writer.write(lambda c: claims.claim_all(c, limits, lease_seconds))

    def waiting_cells(self, limit: int) -> list[int]:
        """Return of each cell how many runs could be claimed now, together.

        No more runs than the limit are counted.
        """
        return self._reader.read(lambda c: claims.waiting_cells(c, limit))

    def count_runs(self) -> dict[str, int]:
        """Return how many runs of all sweeps there are by status, every status named."""
        return self._reader.read(runs.count)

    def count_attempts(self) -> dict[str, int]:
        """Return how many attempts of all runs there were by outcome."""
        return self._reader.read(runs.count_attempts)

    def cancelling_runs(self) -> set[str]:
        """Return the running runs whose workers are to stop them."""
        return self._reader.read(runs.cancelling)

    def record(self, claim: Claim, progress: Progress) -> set[str]:
        """Write what a worker said, renew the lease, end runs that ended by themselves.

        Returns the runs of the claim that go on; the worker is to stop training the others.
        """
        [held] = self.record_all([(claim, progress)])
        return held

    def record_all(self, said: Sequence[tuple[Claim, Progress]]) -> list[set[str]]:
        """Do as `record` with what several workers said, at once. No run is in two of the claims.

        A claim that was given up changes nothing and keeps none of the others from it.
        """
        held = self._writer.write(lambda c: records.record_all(c, said))
        MEASUREMENTS.inc(sum(len(progress.measurements) for _, progress in said))
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
        if not self._reader.read(claims.has_expired):  # usually: then nothing is written
            return 0
        return self._writer.write(lambda c: endings.lose_expired(c, self._retry))

    def ended_with_checkpoints(self, limit: int) -> list[str]:
        """Return runs that have ended and may have files of checkpoints."""
        return self._reader.read(lambda c: checkpoints.of_ended(c, limit))

    def forget_checkpoints(self, run_ids: Sequence[str]) -> None:
        """Note that these runs have no such files, unless they were tried again meanwhile."""
        self._writer.write(lambda c: checkpoints.forget(c, run_ids))

    # ---- what was measured

    def measurements(self, run_id: str) -> list[Measurement]:
        """Return every measurement of a run, in order of timestep."""
        return self._reader.read(lambda c: measurements.of_run(c, run_id))

    def curve_points(
        self, sweep_id: str, metric: str, x: str = "timesteps", ordinal: int | None = None
    ) -> list[RunCurve]:
        """Return one metric of every run of a sweep, or of the one of that ordinal.

        metric is "return_mean", "return_history" or a diagnostic's name; x is "timesteps",
        "updates", "jacobians" or "seconds" (ValueError otherwise).
        """
        return self._reader.read(lambda c: measurements.curves(c, sweep_id, metric, x, ordinal))

    def return_outlines(self, run_ids: Sequence[str], points: int) -> dict[str, list[float]]:
        """Return about so many return_mean of each run, evenly spaced and the latest one last."""
        return self._reader.read(lambda c: measurements.outlines(c, run_ids, points))

    def diagnostic_names(self, sweep_id: str) -> list[str]:
        """Return the names of all diagnostics that runs of the sweep have measured."""
        return self._reader.read(lambda c: measurements.diagnostic_names(c, sweep_id))

    def record_random_return(self, measured: RandomReturn) -> None:
        """Write the random return of one environment version."""
        self._writer.write(lambda c: random_returns.put(c, measured))

    def random_returns(self) -> dict[tuple[str, int], RandomReturn]:
        """Return every random return by (environment, version)."""
        return self._reader.read(random_returns.of_all)

    def past_costs(
        self, algorithms: Collection[str], environments: Collection[str]
    ) -> list[PastCost]:
        """Return what the latest finished runs of these algorithms and environments have cost."""
        return self._reader.read(lambda c: costs.past(c, algorithms, environments))

    # ---- events

    def events_after(
        self, event_id: int, sweep_id: str | None = None, limit: int = 1000
    ) -> list[Event]:
        """Return the oldest events after one, of one sweep or of all."""
        return self._reader.read(lambda c: events.after(c, event_id, sweep_id, limit))

    def last_event_id(self) -> int:
        """Return the newest event's id, 0 when there is none."""
        return self._reader.read(events.last_id)

    def sweep_version(self, sweep_id: str) -> str | None:
        """Return a text that changes with whatever is shown of a sweep; None: no such sweep."""

        def version(connection: Connection) -> str | None:
            last = events.last_id_of(connection, sweep_id)
            zeros = random_returns.last_measured_at(connection)
            return None if last is None else f"{last}-{zeros!r}"

        return self._reader.read(version)
