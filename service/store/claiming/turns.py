"""Whose turn it is, of the sweeps in which runs wait.

Highest priority, then fewest running runs, then longest not served, then oldest; a sweep that holds
as many workers as it may has no turn. Running runs and workers are counted once a transaction,
however many cohorts are claimed in it.
"""

import heapq
import math
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, ScalarSelect, case, func, or_, select

from service.model.run_name import RunName
from service.store.column_types import now
from service.store.tables import attempts, is_queued, is_running, runs, sweeps

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
    def next(self) -> int | None:
        """The number of the sweep whose turn it is; None when nothing waits."""
        return self._order[0][-1] if self._order else None

    def take(self, taken: int) -> None:
        """Note how many runs of that sweep a worker took; where none waits any more, it goes."""
        urgency, running, _, number = heapq.heappop(self._order)
        self._room[number] -= 1
        if taken and self._room[number] > 0:
            heapq.heappush(self._order, (urgency, running + taken, math.inf, number))

    def run_name(self, row: Row[Any]) -> RunName:
        """Return the name of a run of one of these sweeps."""
        return RunName(self._names[row.sweep_number], row.ordinal)
