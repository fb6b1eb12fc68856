"""Runs: reading them."""

from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, Select, false, func, select

from service.model.run import Attempt, Run, RunStatus
from service.model.run_name import RunName
from service.store.reading.rows import noun_of
from service.store.reading.run_order import AS_MADE, RunOrder
from service.store.refusal import NotFoundError
from service.store.tables import attempts, is_running, is_there, runs, sweeps
from workers.messages.run_spec import RunSpec, Weights


def find(connection: Connection, run_id: str) -> Run | None:
    """Return one run, or None."""
    row = connection.execute(_select().where(named(run_id))).one_or_none()
    return None if row is None else run_of(row)


def get(connection: Connection, run_id: str) -> Run:
    """Return one run. Raises NotFoundError."""
    run = find(connection, run_id)
    if run is None:
        raise NotFoundError(f"there is no run {run_id!r}")
    return run


def page(
    connection: Connection,
    sweep_id: str,
    *,
    status: RunStatus | None = None,
    algorithm: str | None = None,
    environment: str | None = None,
    order: RunOrder = AS_MADE,
    after: str | None = None,
    limit: int = 100,
) -> list[Run]:
    """Return runs of a sweep in an order, from the one that follows the run named `after`."""
    query = _select().where(sweeps.c.id == sweep_id).order_by(*order.keys()).limit(limit)
    if status is not None:
        query = query.where(runs.c.status == status)
    if algorithm is not None:
        query = query.where(runs.c.algorithm == algorithm)
    if environment is not None:
        query = query.where(runs.c.environment == environment)
    if after is not None:
        keys = _select().with_only_columns(*order.keys()).where(named(after))
        last = connection.execute(keys).one_or_none()
        query = query.where(false() if last is None else order.after(last))
    return [run_of(row) for row in connection.execute(query)]


def history(connection: Connection, run_id: str) -> list[Attempt]:
    """Return every attempt of a run, the first one first."""
    query = (
        select(attempts)
        .join(runs, runs.c.number == attempts.c.run_number)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(named(run_id))
        .order_by(attempts.c.attempt)
    )
    return [noun_of(Attempt, row) for row in connection.execute(query)]


def count(connection: Connection) -> dict[str, int]:
    """Return how many runs of all sweeps there are by status, every status named."""
    gone = select(sweeps.c.number).where(sweeps.c.deleted_at.is_not(None))
    query = select(runs.c.status, func.count()).group_by(runs.c.status)
    query = query.where(runs.c.sweep_number.not_in(gone))
    counts = {status: number for status, number in connection.execute(query)}  # noqa: C416
    return {status.value: counts.get(status.value, 0) for status in RunStatus}


def count_attempts(connection: Connection) -> dict[str, int]:
    """Return how many attempts of all runs there were by outcome."""
    query = select(attempts.c.outcome, func.count()).group_by(attempts.c.outcome)
    return {outcome: number for outcome, number in connection.execute(query)}  # noqa: C416


def cancelling(connection: Connection) -> set[str]:
    """Return the running runs whose workers are to stop them."""
    query = (
        select(sweeps.c.id, runs.c.ordinal)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(runs.c.is_cancelling, is_running)
    )
    return {str(RunName(*row)) for row in connection.execute(query)}


def named(run_id: str) -> ColumnElement[bool]:
    """Return the condition that picks one run by its name; no run has a malformed name."""
    name = RunName.parse(run_id)
    return (sweeps.c.id == name.sweep_id) & (runs.c.ordinal == name.ordinal) & is_there


def _select() -> Select[Any]:
    return select(runs, sweeps.c.id.label("sweep_id")).join(
        sweeps, sweeps.c.number == runs.c.sweep_number
    )


def run_of(row: Row[Any]) -> Run:
    """Read a run off a row of `runs` with the id of its sweep."""
    name = str(RunName(row.sweep_id, row.ordinal))
    return noun_of(Run, row, id=name, spec=spec_of(row), status=RunStatus(row.status))


def spec_of(row: Row[Any]) -> RunSpec:
    """Read the spec off a row of `runs`."""
    return noun_of(RunSpec, row, weights=Weights(row.w1, row.w2))


def columns_of(spec: RunSpec) -> dict[str, Any]:
    """Write a spec as values of a row of `runs`."""
    fields = spec.to_json()
    return {**fields.pop("weights"), **fields}
