"""Whose turn it is: of the sweeps in which runs wait, and of the runs in one (`Line`).

Highest priority, then fewest running runs, then longest not served, then oldest; a sweep that holds
as many workers as it may has no turn. Running runs and workers are counted once a transaction,
however many cohorts are claimed in it.
"""

import heapq
import math
from collections.abc import Sequence
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Row,
    ScalarSelect,
    and_,
    case,
    func,
    or_,
    select,
    true,
)

from service.model.claim import CellLimit
from service.model.run_name import RunName
from service.store.at_once import among
from service.store.column_types import now
from service.store.reading.runs import spec_of
from service.store.tables import attempts, is_queued, is_running, runs, sweeps
from workers.messages.run_spec import COHORT_LIMIT

ALONE_AFTER = 2
"""A run that lost this many workers in a row trains alone, so that no other is lost with it."""

Cohort = Sequence[Row[Any]]
"""Runs of one cell that train together, in the order of their sweep."""

is_waiting = is_queued & (runs.c.not_before <= now())


def held_workers() -> ScalarSelect[int]:
    """Return how many workers train runs of a row of `sweeps`."""
    current = (attempts.c.run_number == runs.c.number) & (attempts.c.attempt == runs.c.attempt)
    return (
        select(func.count(attempts.c.worker.distinct()))
        .select_from(runs)
        .join(attempts, current)
        .where(runs.c.sweep_number == sweeps.c.number, is_running)
        .correlate(sweeps)
        .scalar_subquery()
    )


def has_room() -> ColumnElement[bool]:
    """Return the condition that a row of `sweeps` may have one more worker."""
    return or_(sweeps.c.max_workers.is_(None), held_workers() < sweeps.c.max_workers)


class Turns:
    """The sweeps in which a run may wait, in a transaction that claims."""

    def __init__(self, connection: Connection) -> None:
        """Find them."""
        of_sweep = runs.c.sweep_number == sweeps.c.number
        # No EXISTS: PostgreSQL would look at every queued run of every sweep.
        waiting = select(runs.c.number).where(of_sweep, is_waiting).correlate(sweeps).limit(1)
        running = select(func.count()).where(of_sweep, is_running).correlate(sweeps)
        ranked_by = (sweeps.c.priority, running.scalar_subquery().label("running"))
        limit = sweeps.c.max_workers
        room = case((limit.is_not(None), limit - held_workers())).label("room")
        found = connection.execute(
            select(sweeps.c.number, sweeps.c.id, *ranked_by, sweeps.c.last_claimed_at, room).where(
                waiting.scalar_subquery().is_not(None)
            )
        ).all()
        self._names = {row.number: row.id for row in found}
        self._room = {row.number: math.inf if row.room is None else row.room for row in found}
        self._order = [
            (-r.priority, r.running, r.last_claimed_at, r.number)
            for r in found
            if self._room[r.number] > 0
        ]
        heapq.heapify(self._order)

    @property
    def sweeps(self) -> list[int]:
        """The numbers of the sweeps that may have a turn."""
        return [number for *_, number in self._order]

    @property
    def next(self) -> int | None:
        """The number of the sweep whose turn it is; None when nothing waits."""
        return self._order[0][-1] if self._order else None

    def take(self, taken: int) -> None:
        """Count the runs of that sweep that a worker took; drop a sweep without waiting runs."""
        urgency, running, _, number = heapq.heappop(self._order)
        self._room[number] -= 1
        if taken and self._room[number] > 0:
            heapq.heappush(self._order, (urgency, running + taken, math.inf, number))

    def run_name(self, row: Row[Any]) -> RunName:
        """Return the name of a run of one of these sweeps."""
        return RunName(self._names[row.sweep_number], row.ordinal)


class Line:
    """The runs of a sweep that wait for a worker, in a transaction that claims.

    They are read many at once and taken out cohort by cohort. The caller changes their status
    before the transaction ends.
    """

    def __init__(self, connection: Connection, sweep_number: int, cohorts: int) -> None:
        """Read as many runs at once as this many cohorts can have."""
        self._connection = connection
        self._of_sweep = runs.c.sweep_number == sweep_number
        self._size = cohorts * COHORT_LIMIT
        self._front: Cohort = ()
        self._has_more = True  # behind those at the front
        self._taken: set[int] = set()

    def take(self, limit: CellLimit) -> Cohort:
        """Take the first run out, and others of its cell that were left at the same timestep.

        None where nothing waits any more.
        """
        if not self._front and self._has_more:
            self._front = self._find(true(), self._size)
            self._has_more = len(self._front) == self._size
        if not self._front:
            return ()
        cohort = self._cohort(self._front[0], limit)
        self._taken.update(row.number for row in cohort)
        self._front = [row for row in self._front if row.number not in self._taken]
        return cohort

    def _cohort(self, first: Row[Any], limit: CellLimit) -> Cohort:
        if first.losses >= ALONE_AFTER:
            return [first]
        most = min(limit(spec_of(first).cell), COHORT_LIMIT)
        near = [row for row in self._front if _train_together(first, row)]
        if len(near) >= most or not self._has_more:
            return near[:most]
        mates = and_(
            runs.c.cell == first.cell,
            runs.c.losses < ALONE_AFTER,
            runs.c.checkpoint_timestep == first.checkpoint_timestep,
        )
        return self._find(mates, most)

    def _find(self, condition: ColumnElement[bool], limit: int) -> Cohort:
        """Read runs that wait and were not taken out."""
        is_left = ~among(runs.c.number, self._taken) if self._taken else true()
        query = (
            select(runs)
            .where(self._of_sweep, is_waiting, condition, is_left)
            .order_by(runs.c.ordinal)
            .limit(limit)
        )
        return self._connection.execute(query).all()


def _train_together(first: Row[Any], other: Row[Any]) -> bool:
    return bool(
        other.cell == first.cell
        and other.losses < ALONE_AFTER
        and other.checkpoint_timestep == first.checkpoint_timestep
    )
