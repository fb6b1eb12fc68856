"""Which ends of sweeps to deliver to webhooks, and the results of these deliveries.

An end is delivered when no run is active any more, no question is open, and the latest run ended
after the last delivered end. So it is delivered again when a sweep has ended again.
"""

from sqlalchemy import Connection, func, select, update

from service.model.run import ACTIVE
from service.model.webhook import Due
from service.store.column_types import now
from service.store.reading import events
from service.store.reading.sweeps import get
from service.store.tables import is_asking, is_there, runs, sweeps

MOST_TRIES = 20
LONGEST_WAIT_SECONDS = 600.0


def due(connection: Connection, limit: int) -> list[Due]:
    """Return the ends to deliver now."""
    of_sweep = runs.c.sweep_number == sweeps.c.number
    is_active = select(runs.c.number).where(of_sweep, runs.c.status.in_(ACTIVE)).exists()
    ended_at = select(func.max(runs.c.finished_at)).where(of_sweep).scalar_subquery()
    query = (
        select(sweeps.c.id, sweeps.c.webhook, sweeps.c.webhook_tries, ended_at)
        .where(
            sweeps.c.webhook.is_not(None),
            is_there,
            sweeps.c.webhook_not_before <= now(),
            ~is_active,
            ~is_asking,
            func.coalesce(sweeps.c.webhook_delivered_at, 0.0) < ended_at,
        )
        .order_by(sweeps.c.webhook_not_before, sweeps.c.number)
        .limit(limit)
    )
    return [
        Due(get(connection, sweep_id), url, tries, at)
        for sweep_id, url, tries, at in connection.execute(query).all()
    ]


def note(connection: Connection, told: Due, problem: str) -> None:
    """Write the result of a delivery: that it succeeded, or what the problem was."""
    tries = told.tries + 1 if problem else 0
    is_over = not problem or tries >= MOST_TRIES
    wait = min(2.0**tries, LONGEST_WAIT_SECONDS) if problem and not is_over else 0.0
    delivered = told.ended_at if is_over else sweeps.c.webhook_delivered_at
    is_sweep = (sweeps.c.id == told.sweep.id) & (sweeps.c.webhook == told.url)
    number = connection.scalar(
        update(sweeps)
        .where(is_sweep)
        .values(
            webhook_delivered_at=delivered,
            webhook_tries=0 if is_over else tries,
            webhook_problem=problem,
            webhook_not_before=now() + wait,
        )
        .returning(sweeps.c.number)
    )
    if number is not None:
        events.append(connection, [events.sweep_changed(number, told.sweep.id, "told")])
