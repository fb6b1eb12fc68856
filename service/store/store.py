"""The store: every query and command of the service on the database.

Promises. Safe from any thread. Every method is one transaction: all of it happens or nothing, and
what a method returned has survived a power cut. A crash leaves the last committed state. Final
states never change, except that users may retry what failed, and a write under a claim that was
given up changes nothing. Every change appends its event in the same transaction. Floats come back
as they went in (see `column_types.Exact`), NaN and infinities too. The store waits for a database
that restarts (`outage`): what was under way then happens once, and late.

Most methods are a query or a command of another file, which says there what it does to a
connection: `find_run = _reads(runs.find)`.

One store writes to a database: a second is refused (on SQLite by the lock on the data directory).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Concatenate, ParamSpec, Self, TypeVar

from sqlalchemy import URL, Connection, Engine, make_url, text
from sqlalchemy.exc import DBAPIError

from service.metrics import MEASUREMENTS
from service.model.claim import CellLimit, Claim, no_limit
from service.store import people, records
from service.store.claiming import (
    bulk,
    checkpoints,
    claims,
    deletion,
    endings,
    growth,
    run_moves,
    sweep_edits,
    sweep_moves,
    webhooks,
)
from service.store.claiming.inquiry import question_batches, search_rungs
from service.store.claiming.retry import RetryPolicy
from service.store.connection import connect
from service.store.curve_memory import CurveMemory
from service.store.reader import Reader
from service.store.reading import (
    costs,
    curves,
    diagnoses,
    events,
    occupation,
    runs,
    standings,
    sweep_names,
    sweeps,
)
from service.store.reading import measurements as measured
from service.store.reading import random_returns as zeros
from service.store.refusal import UnusableDatabaseError
from service.store.unusable import unusable
from service.store.upkeep.migration import upgrade
from service.store.writer import Writer
from workers.messages.progress import Progress
from workers.messages.run_spec import COHORT_LIMIT

MOST_CURVE_BYTES = 100_000_000

P = ParamSpec("P")
Result = TypeVar("Result")


def _reads(
    query: Callable[Concatenate[Connection, P], Result],
) -> Callable[Concatenate[Store, P], Result]:
    """Return the method that finds what the query finds."""

    @wraps(query)
    def method(store: Store, /, *args: P.args, **kwargs: P.kwargs) -> Result:
        return store.read(query, *args, **kwargs)

    return method


def _remembers(
    query: Callable[Concatenate[Connection, CurveMemory, P], Result],
) -> Callable[Concatenate[Store, P], Result]:
    """Return the method that finds what the query finds, with the store's memory of curves."""

    @wraps(query)
    def method(store: Store, /, *args: P.args, **kwargs: P.kwargs) -> Result:
        return store.read(query, store.curve_memory, *args, **kwargs)

    return method


def _writes(
    command: Callable[Concatenate[Connection, P], Result],
) -> Callable[Concatenate[Store, P], Result]:
    """Return the method that does what the command does."""

    @wraps(command)
    def method(store: Store, /, *args: P.args, **kwargs: P.kwargs) -> Result:
        return store.write(command, *args, **kwargs)

    return method


class Store:
    """One open database. `Store.open` makes one; `close` commits what is queued and ends it."""

    def __init__(self, writer_engine: Engine, reader_engine: Engine, retry: RetryPolicy) -> None:
        """Start the writer's thread on tables that are this version's."""
        self._writer_engine = writer_engine
        self._reader = Reader(reader_engine)
        self._retry = retry
        self._writer = Writer(writer_engine)
        self.curve_memory = CurveMemory(MOST_CURVE_BYTES)

    @classmethod
    def open(cls, url: str | URL, retry: RetryPolicy | None = None) -> Self:
        """Open the database, after bringing its tables to this version's. Raises RefusalError."""
        writer = connect(url, "writer")
        try:
            upgrade(writer)
        except DBAPIError as error:
            writer.dispose()
            raise UnusableDatabaseError(unusable(make_url(url), error)) from error
        return cls(writer, connect(url, "reader"), retry or RetryPolicy())

    def close(self) -> None:
        """Commit what is queued and close the database."""
        self._writer.close()
        self._reader.close()
        self._writer_engine.dispose()

    def check(self) -> None:
        """Read something, and write if the last write failed; raises what the database raises.

        Without the write, a full disk would be reported as full until the next write.
        """
        self._reader.read(lambda c: c.execute(text("SELECT 1 FROM runs LIMIT 1")).all())
        if self._writer.is_failing:
            self._writer.write(lambda _: None)  # the commit's name is written

    def read(
        self,
        query: Callable[Concatenate[Connection, P], Result],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> Result:
        """Run the query in a transaction of its own, and return its result."""
        return self._reader.read(lambda connection: query(connection, *args, **kwargs))

    def write(
        self,
        command: Callable[Concatenate[Connection, P], Result],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> Result:
        """Run the command in a transaction of its own, and return its result."""
        return self._writer.write(lambda connection: command(connection, *args, **kwargs))

    # ---- sweeps and runs

    create_sweep = _writes(sweeps.create)
    find_sweep = _reads(sweeps.find)
    get_sweep = _reads(sweeps.get)
    sweep_request = _reads(sweeps.request)
    sweep_owners = _reads(sweeps.owners)
    sweep_version = _reads(sweeps.version)
    list_sweeps = _reads(sweeps.page)
    sweep_standings = _reads(standings.of_sweeps)
    sweep_outlines = _reads(standings.outlines)
    sweep_tags = _reads(sweep_names.all_tags)
    edit_sweep = _writes(sweep_edits.edit)
    sweep_cells = _reads(growth.cells)
    add_seeds = _writes(growth.add_seeds)
    add_entries = _writes(growth.add_entries)
    extend_sweep = _writes(growth.extend)
    refuse_growth = _reads(growth.refuse)
    delete_sweep = _writes(deletion.delete_sweep)
    move_all = _writes(bulk.move_all)
    move_sweep = _writes(sweep_moves.move_sweep)
    find_run = _reads(runs.find)
    list_runs = _reads(runs.page)
    move_run = _writes(run_moves.move_run)
    attempts = _reads(runs.history)
    waiting_questions = _reads(question_batches.waiting)
    go_on_asking = _writes(question_batches.go_on)
    go_on_searching = _writes(search_rungs.go_on)
    list_searches = _reads(sweeps.searches)

    # ---- the queue

    waiting_cells = _reads(claims.waiting_cells)
    training = _reads(occupation.training)
    waiting_sweeps = _reads(occupation.waiting)
    count_runs = _reads(runs.count)
    count_attempts = _reads(runs.count_attempts)
    cancelling_runs = _reads(runs.cancelling)
    fail = _writes(endings.fail)
    release = _writes(endings.release)
    ended_with_checkpoints = _reads(checkpoints.of_ended)
    keep_last = _writes(checkpoints.keep)
    checkpoints_beyond = _reads(checkpoints.kept_beyond)
    forget_checkpoints = _writes(checkpoints.forget)

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
        """Apply `claim_cohort` to several workers (worker, limit), in order and at once."""

        def at_most(limit: int) -> CellLimit:
            return lambda cell: min(limit, limit_of(cell), COHORT_LIMIT)

        limits = [(worker, at_most(limit)) for worker, limit in asked]
        return self.write(claims.claim_all, limits, lease_seconds)

    def record(self, claim: Claim, progress: Progress) -> set[str]:
        """Write the report of a worker, renew the lease, end runs that ended by themselves.

        Returns the runs of the claim that go on; the worker must stop training the others.
        """
        [held] = self.record_all([(claim, progress)])
        return held

    def record_all(self, said: Sequence[tuple[Claim, Progress]]) -> list[set[str]]:
        """Apply `record` to the reports of several workers at once. No run is in two of the claims.

        A claim that was given up changes nothing and does not affect the others.
        """
        held = self.write(records.record_all, said)
        MEASUREMENTS.inc(sum(len(progress.measurements) for _, progress in said))
        return held

    def lose(self, claim: Claim, reason: str, log_tail: str = "") -> None:
        """Queue the runs of the claim again after a wait, or fail them after too many losses."""
        self.write(endings.lose, claim, reason, log_tail, self._retry)

    def lose_expired(self) -> int:
        """Apply `lose` to every run whose lease has ended; return how many there were."""
        if not self.read(claims.has_expired):  # usually: then nothing is written
            return 0
        return self.write(endings.lose_expired, self._retry)

    due_webhooks = _reads(webhooks.due)
    note_webhook = _writes(webhooks.note)

    # ---- throwing away

    deleted_runs = _reads(deletion.deleted_runs)
    purge_runs = _writes(deletion.purge_runs)
    purge_sweep = _writes(deletion.purge_sweep)
    purge_events = _writes(deletion.purge_events)
    old_policies = _reads(deletion.old_policies)
    forget_policies = _writes(deletion.forget_policies)

    # ---- what was measured

    measurements = _reads(measured.of_run)
    sweep_measurements = _reads(measured.of_runs)
    curves = _remembers(curves.curves)
    return_outlines = _reads(measured.outlines)
    diagnostic_names = _reads(measured.diagnostic_names)
    record_random_return = _writes(zeros.put)
    random_returns = _reads(zeros.of_all)
    past_costs = _reads(costs.past)

    # ---- diagnoses

    find_diagnosis = _reads(diagnoses.of_run)
    list_diagnoses = _reads(diagnoses.of_sweep)
    ask_diagnoses = _writes(diagnoses.ask)
    next_waiting_diagnosis = _reads(diagnoses.next_waiting)
    record_diagnosis = _writes(diagnoses.record)

    # ---- people

    users = _reads(people.all_users)
    add_user = _writes(people.add_user)
    revoke_user = _writes(people.revoke_user)
    shares = _reads(people.all_shares)
    add_share = _writes(people.add_share)
    remove_share = _writes(people.remove_share)
    sessions = _reads(people.all_sessions)
    add_session = _writes(people.add_session)
    remove_session = _writes(people.remove_session)

    # ---- events

    events_after = _reads(events.after)
    last_event_id = _reads(events.last_id)
