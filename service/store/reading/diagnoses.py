"""Diagnoses: which are requested, and their findings; one a run, of its last attempt.

Findings are a JSON list of rows: diagnostic, quantity, horizon, noise, value. Null means NaN.
"""

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Row,
    Select,
    and_,
    delete,
    func,
    insert,
    select,
    update,
)

from algorithms.diagnostics.finding import Finding
from service.model.diagnosis import Diagnosis
from service.model.run import FINAL, Run, RunStatus
from service.model.run_name import RunName
from service.store.at_once import among
from service.store.reading import events
from service.store.reading.runs import named, run_of, select_runs
from service.store.refusal import NotFoundError, TooManyAskedError
from service.store.tables import diagnoses, runs, sweeps

IS_OF_RUN = and_(diagnoses.c.run_number == runs.c.number, diagnoses.c.attempt == runs.c.attempt)
IS_WAITING = and_(diagnoses.c.is_waiting, runs.c.status.in_(FINAL))


def of_run(connection: Connection, run_id: str) -> Diagnosis:
    """Return the diagnosis of a run, made or not. Raises NotFoundError."""
    row = connection.execute(_select().where(named(run_id))).one_or_none()
    if row is None:
        raise NotFoundError(f"there is no run {run_id!r}")
    return _diagnosis(row)


def of_sweep(
    connection: Connection,
    sweep_id: str,
    *,
    most_of_cell: int,
    environment: str | None = None,
) -> list[Diagnosis]:
    """Return the diagnoses, made or not, of the first runs of each cell that reached their end.

    Args:
        connection: to the database.
        sweep_id: the sweep.
        most_of_cell: of how many runs of a cell, at most.
        environment: of the runs in this one alone.
    """
    place = func.row_number().over(partition_by=runs.c.cell, order_by=runs.c.ordinal).label("place")
    reached = (
        select(runs.c.number, place)
        .join(sweeps, sweeps.c.number == runs.c.sweep_number)
        .where(sweeps.c.id == sweep_id, runs.c.status == RunStatus.SUCCEEDED)
    )
    if environment is not None:
        reached = reached.where(runs.c.environment == environment)
    first = reached.subquery()
    query = (
        _select()
        .join(first, first.c.number == runs.c.number)
        .where(first.c.place <= most_of_cell)
        .order_by(runs.c.ordinal)
    )
    return [_diagnosis(row) for row in connection.execute(query)]


def ask(connection: Connection, asked: Sequence[Run], most_waiting: int) -> None:
    """Request the diagnoses of runs of one sweep; those that wait or are made stay unchanged.

    Raises TooManyAskedError where more than `most_waiting` would wait, of all sweeps.
    """
    rows = connection.execute(_select().where(_any_of(asked))).all()
    new = [row for row in rows if not row.is_waiting and row.findings is None]
    if not new:
        return
    waiting = connection.scalar(_waiting().with_only_columns(func.count())) or 0
    if waiting + len(new) > most_waiting:
        raise TooManyAskedError(
            f"{waiting} diagnoses wait already, and {len(new)} more would be more than "
            f"{most_waiting}"
        )
    numbers = [row.number for row in new]
    connection.execute(delete(diagnoses).where(among(diagnoses.c.run_number, numbers)))
    entries = [{"run_number": row.number, "attempt": row.attempt} for row in new]
    connection.execute(insert(diagnoses), entries)
    events.append(connection, [events.diagnosed(new[0].sweep_number, new[0].sweep_id)])


def next_waiting(connection: Connection) -> Run | None:
    """Return the run whose diagnosis has waited longest; None if none waits."""
    oldest = _waiting().order_by(diagnoses.c.asked_at, diagnoses.c.run_number).limit(1)
    row = connection.execute(oldest).one_or_none()
    return None if row is None else run_of(row)


def record(
    connection: Connection, run: Run, findings: Iterable[Finding] | None, problem: str = ""
) -> None:
    """Write the findings about an attempt of a run, or why there are none.

    Nothing changes if the diagnosis does not wait any more.
    """
    row = connection.execute(_waiting().where(named(run.id))).one_or_none()
    if row is None or row.attempt != run.attempt:
        return
    written = None if findings is None else _text(findings)
    change = update(diagnoses).where(diagnoses.c.run_number == row.number)
    connection.execute(change.values(is_waiting=False, findings=written, problem=problem))
    events.append(connection, [events.diagnosed(row.sweep_number, row.sweep_id, run.id)])


def _select() -> Select[Any]:
    """Runs, each with its diagnosis where there is one."""
    found = diagnoses.c
    columns = (found.is_waiting, found.findings, found.problem)
    return select_runs().add_columns(*columns).outerjoin(diagnoses, IS_OF_RUN)


def _waiting() -> Select[Any]:
    """The runs whose diagnoses wait."""
    return _select().where(IS_WAITING)


def _any_of(asked: Sequence[Run]) -> ColumnElement[bool]:
    ordinals = [RunName.parse(run.id).ordinal for run in asked]
    return and_(sweeps.c.id == asked[0].sweep_id, among(runs.c.ordinal, ordinals))


def _diagnosis(row: Row[Any]) -> Diagnosis:
    findings = None if row.findings is None else tuple(_findings(row.findings))
    return Diagnosis(run_of(row), bool(row.is_waiting), findings, row.problem or "")


def _text(findings: Iterable[Finding]) -> str:
    rows = [(*name, value if math.isfinite(value) else None) for *name, value in findings]
    return json.dumps(rows, allow_nan=False)


def _findings(text: str) -> Iterable[Finding]:
    for diagnostic, quantity, horizon, noise, value in json.loads(text):
        yield Finding(diagnostic, quantity, horizon, noise, math.nan if value is None else value)
