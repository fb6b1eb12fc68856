"""Whose turn it is, of the sweeps in which runs wait.

Highest priority, then fewest running runs, then longest not served, then oldest. Running runs are
counted once a transaction, however many cohorts are claimed in it.
"""

import heapq
import math
from typing import Any

from sqlalchemy import Connection, Row, func, select

from service.model.run_name import RunName
from service.store.column_types import now
from service.store.tables import is_queued, is_running, runs, sweeps

is_waiting = is_queued & (runs.c.not_before <= now())


class Turns:
    """The sweeps in which a run may wait, in a transaction that claims."""

    def __init__(self, connection: Connection) -> None:
        """Find them."""
        of_sweep = runs.c.sweep_number == sweeps.c.number
        # No EXISTS: PostgreSQL would look at every queued run of every sweep.
        waiting = select(runs.c.number).where(of_sweep, is_waiting).correlate(sweeps).limit(1)
        running = select(func.count()).where(of_sweep, is_running).correlate(sweeps)
        ranked_by = (sweeps.c.priority, running.scalar_subquery().label("running"))
        found = connection.execute(
            select(sweeps.c.number, sweeps.c.id, *ranked_by, sweeps.c.last_claimed_at).where(
                waiting.scalar_subquery().is_not(None)
            )
        ).all()
        self._names = {row.number: row.id for row in found}
        self._order = [(-r.priority, r.running, r.last_claimed_at, r.number) for r in found]
        heapq.heapify(self._order)

    @property
    def next(self) -> int | None:
        """The number of the sweep whose turn it is; None when nothing waits."""
        return self._order[0][-1] if self._order else None

    def take(self, taken: int) -> None:
        """Note how many runs of that sweep were taken; where none waits any more, it goes."""
        urgency, running, _, number = heapq.heappop(self._order)
        if taken:
            heapq.heappush(self._order, (urgency, running + taken, math.inf, number))

    def run_name(self, row: Row[Any]) -> RunName:
        """Return the name of a run of one of these sweeps."""
        return RunName(self._names[row.sweep_number], row.ordinal)
